"""Port reader: opens a port, has it drained by a process of its own, and hands on what that has kept.

Whoever waits for frames takes what there is himself (`PortReader.poll`): the way over another thread costs two changes
of threads a packet, and the interpreter serves one at a time. Only while he is busy the reader's own thread does, so
that what came is recorded soon whatever the pipeline does.
"""

import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.serial.drain import DATA, DROPPED, GONE
from tactile.serial.drained import Drained
from tactile.serial.port import open_port, take
from tactile.wire.base import Talk
from tactile.wire.source import FORCED_TARE, PLUGGED, TARE, UNPLUGGED, Chunk

FIRST_PAUSE, LONGEST_PAUSE = 0.1, 0.5
"""[s] between tries to open a port that was unplugged: doubled each time."""
WAIT = 0.05
"""[s] after which a thread that gets nothing looks whether it is to stop."""
TURN = 0.01
"""[s] from one look of the reader's thread to the next whether somebody takes what comes."""


class PortReader:
    """Opens a port when it is made and reads it after `start`; chunks count nanoseconds from ``epoch``.

    ``hand_on`` is called with what has come, and with nothing while nothing comes, by one thread at a time: the
    reader's, or that of `poll`; ``ended`` after the last chunk. A bad frame is not its business: only a port that fails
    is closed, and opened again until it is back; ``once``: it stays closed. ``why`` says why it is not open just now,
    ``plugged`` [ns] on the clock of the chunks since when it is; ``dropped`` bytes had no room.

    Raises:
        InputError: the port cannot be opened the first time.
    """

    def __init__(
        self, name: str, baudrate: int, talk: Talk, hand_on: Callable[[list[Chunk]], None],
        ended: Callable[[], None] = lambda: None, once: bool = False,
    ) -> None:  # fmt: skip
        self.unplugged = self.dropped = self.plugged = 0
        self.why = ""
        self._name, self._baudrate, self._talk = name, baudrate, talk
        self._hand_on, self._ended, self._once = hand_on, ended, once
        self._stop, self._wake = threading.Event(), threading.Event()
        self._turn, self._attached = threading.Lock(), False
        self._failed: OSError | None = None
        self._drained = Drained() if CAN_DRAIN else None
        try:
            self._port = open_port(name, baudrate)
        except BaseException:
            self._let_drain_end()
            raise
        self.epoch = Epoch.now()
        self._thread = threading.Thread(target=self._run, name=f"port {name}", daemon=True)

    def start(self) -> None:
        """Begin to read; what the system has kept since the port was opened came nobody knows when."""
        with suppress(Exception):  # the port is gone, which reading it tells
            self._port.reset_input_buffer()
        self._thread.start()

    def ask_tare(self, force: bool = False) -> None:
        """Put a request for a tare into the stream, where a recording keeps it; by ``force`` also of what is loaded."""
        self._note(FORCED_TARE if force else TARE)

    def close(self) -> None:
        """Stop reading and let go of the port; what has come by now is handed on."""
        self._stop.set()
        self._wake.set()
        if self._thread.ident is None:  # it never began
            self._port.close()
            self._let_drain_end()
        else:
            self._thread.join()

    def poll(self, timeout: float) -> bool:
        """Hand on in this thread what has come, waiting up to ``timeout`` [s]; False where the reader's own has to."""
        if not self._turn.acquire(blocking=False):
            return False
        try:
            return self._attached and self._take(timeout)
        finally:
            self._turn.release()

    def now(self) -> int:
        """Return [ns] since the epoch."""
        return time.monotonic_ns() - self.epoch.monotonic

    def _let_drain_end(self) -> None:
        if self._drained is not None:
            self._drained.close()

    def _note(self, text: str) -> None:
        self._hand_on([Chunk(self.now(), note=text)])

    def _run(self) -> None:
        read = self._read_here if self._drained is None else self._read_drained
        try:
            while not self._stop.is_set():
                self.plugged = self.now()
                self._note(PLUGGED)
                try:
                    read()
                except OSError as error:  # SerialException is one
                    self.why = str(error)
                finally:
                    self._port.close()
                if not self._stop.is_set():
                    self._note(UNPLUGGED)
                    self.unplugged += 1
                    if self._once:
                        break
                    self._reopen()
        finally:
            self._let_drain_end()
            self._ended()

    def _read_drained(self) -> None:
        """Hand on what the draining process has until the port fails; at the end, all that it still has."""
        assert self._drained is not None
        if self._drained.over:
            self._drained.close()
            self._drained = Drained()
        self._drained.read(self._port, self._talk)
        self._failed, self._attached = None, True
        try:
            while not self._stop.is_set() and self._failed is None:
                self._wake.wait(TURN)
                self.poll(0)
        finally:
            self._wake.clear()
            with self._turn:
                self._attached = False
        if self._failed is None:
            self._drained.finish()
        while self._failed is None and not self._drained.over:
            self._take(WAIT)
        if self._failed is not None:
            raise self._failed

    def _take(self, timeout: float) -> bool:
        """Hand on what the draining process has, and note if the port has failed."""
        assert self._drained is not None
        records = self._drained.take(timeout)
        start = self.epoch.monotonic
        self._hand_on([Chunk(t - start, data) for kind, t, data in records if kind == DATA])
        self.dropped += sum(int(data) for kind, _, data in records if kind == DROPPED)
        if gone := [data for kind, _, data in records if kind == GONE]:
            self._failed = OSError(gone[0].decode())
        elif self._drained.over and not self._stop.is_set():
            self._failed = OSError("the process that reads the port has ended")
        if self._failed is not None:
            self._attached = False
            self._wake.set()
        return True

    def _read_here(self) -> None:
        """Read where no port can be given to another process: it waits for the other threads' turns."""
        port, talk = self._port, self._talk
        wait = min(WAIT, talk.period) if talk.poll else WAIT
        if talk.hello:
            port.write(talk.hello)
        asked = 0
        while not self._stop.is_set():
            if talk.poll and time.monotonic_ns() - asked >= talk.period * 1e9:
                asked = time.monotonic_ns()
                port.write(talk.poll)
            data = take(port, wait)
            self._hand_on([Chunk(self.now(), data)] if data else [])

    def _reopen(self) -> None:
        pause = FIRST_PAUSE
        while not self._stop.wait(pause):
            try:
                self._port = open_port(self._name, self._baudrate)
            except InputError as error:
                self.why = str(error)
                pause = min(2 * pause, LONGEST_PAUSE)
            else:
                self.why = ""
                return


CAN_DRAIN = hasattr(socket, "send_fds")
"""Whether this system lets a process give an open port to another; Windows does not."""
