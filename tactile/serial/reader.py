"""Port reader: opens a port, has it read by a drain process, and forwards the chunks.

The thread that waits for frames takes the chunks itself (`PortReader.poll`), because a second thread costs two thread
switches per packet. While it is busy the reader's own thread takes them, so that they are recorded soon.
"""

import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.serial.drain import DATA, DROPPED, GONE
from tactile.serial.drained import Drained
from tactile.serial.port import open_port
from tactile.wire.base import Talk
from tactile.wire.source import FORCED_TARE, PLUGGED, TARE, UNPLUGGED, Chunk

FIRST_PAUSE, LONGEST_PAUSE = 0.1, 0.5
"""[s] Pause between attempts to open an unplugged port, doubled each time."""
WAIT = 0.05
"""[s] Longest wait before a thread checks whether to stop."""
TURN = 0.01
"""[s] Period at which the reader's thread checks whether another thread polls."""


class PortReader:
    """Opens a port when made and reads it after `start`; times of chunks count in nanoseconds from ``epoch``.

    ``hand_on`` is called with new chunks, also with an empty list, by one thread at a time: the reader's or that of
    `poll`; ``ended`` after the last chunk. A port that fails is closed and opened again when it is back, unless
    ``once``. ``why`` is the reason why it is closed now, ``dropped`` the number of lost bytes.

    Raises:
        InputError: the port cannot be opened the first time.
    """

    def __init__(
        self, name: str, baudrate: int, talk: Talk, hand_on: Callable[[list[Chunk]], None],
        ended: Callable[[], None] = lambda: None, once: bool = False,
    ) -> None:  # fmt: skip
        self.unplugged = self.dropped = 0
        self.why = ""
        self._name, self._baudrate, self._talk = name, baudrate, talk
        self._hand_on, self._ended, self._once = hand_on, ended, once
        self._stop = threading.Event()
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
        """Begin to read; bytes that the system buffered before are discarded, because their time is unknown."""
        with suppress(Exception):  # a failed port is reported when read
            self._port.reset_input_buffer()
        self._thread.start()

    def ask_tare(self, force: bool = False) -> None:
        """Put a tare request into the stream and the recording; ``force``: also of a loaded array."""
        self._note(FORCED_TARE if force else TARE)

    def close(self) -> None:
        """Stop reading and close the port; bytes received so far are forwarded."""
        self._stop.set()
        if self._thread.ident is None:  # never started
            self._port.close()
            self._let_drain_end()
        else:
            self._thread.join()

    def poll(self, timeout: float) -> bool:
        """Forward chunks in this thread, waiting up to ``timeout`` [s]; False where the reader's own thread must."""
        if not self._turn.acquire(blocking=False):
            return False
        try:
            return self._attached and self._failed is None and self._take(timeout)
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
        """Forward chunks of the drain process until the port fails; at the end, all that remain."""
        assert self._drained is not None
        if self._drained.over:
            self._drained.close()
            self._drained = Drained()
        self._drained.read(self._port, self._talk)
        self._failed, self._attached = None, True
        try:
            while self._failed is None and not self._stop.wait(TURN):
                self.poll(0)
        finally:
            with self._turn:
                self._attached = False
        if self._failed is None:
            self._drained.finish()
        while self._failed is None and not self._drained.over:
            self._take(WAIT)
        if self._failed is not None:
            raise self._failed

    def _take(self, timeout: float) -> bool:
        """Forward chunks of the drain process, and note a failed port."""
        assert self._drained is not None
        records = self._drained.take(timeout)
        start = self.epoch.monotonic
        self._hand_on([Chunk(t - start, data) for kind, t, data in records if kind == DATA])
        self.dropped += sum(int(data) for kind, _, data in records if kind == DROPPED)
        if gone := [data for kind, _, data in records if kind == GONE]:
            self._failed = OSError(gone[0].decode())
        elif self._drained.over and not self._stop.is_set():
            self._failed = OSError("the process that reads the port has ended")
        return True

    def _read_here(self) -> None:
        """Read in this thread where a port cannot be passed to another process."""
        port, talk = self._port, self._talk
        port.timeout = min(WAIT, talk.period) if talk.poll else WAIT
        if talk.hello:
            port.write(talk.hello)
        asked = 0
        while not self._stop.is_set():
            if talk.poll and time.monotonic_ns() - asked >= talk.period * 1e9:
                asked = time.monotonic_ns()
                port.write(talk.poll)
            data = port.read(1)
            self._hand_on([Chunk(self.now(), data + port.read(port.in_waiting))] if data else [])

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


CAN_DRAIN = os.name == "posix"
"""Whether an open port can be passed to another process; not on Windows."""
