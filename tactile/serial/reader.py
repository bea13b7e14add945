"""Port reader: the one thread that owns the port; it reads, stamps and hands on, and never waits for anyone else."""

import threading
import time

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.serial.port import open_port, take
from tactile.serial.ring import Ring
from tactile.wire.base import Talk
from tactile.wire.source import PLUGGED, TARE, UNPLUGGED, Chunk

FIRST_PAUSE, LONGEST_PAUSE = 0.1, 0.5
"""[s] between tries to open a port that was unplugged: doubled each time."""
WAIT = 0.05
"""[s] after which a thread that reads nothing looks whether it is to stop."""


class PortReader:
    """Opens a port when it is made and reads it into a ring after `start`; chunks count nanoseconds from ``epoch``.

    A bad frame is not its business: only a port that fails is closed, and opened again, later and later, until it is
    back; ``once``: it stays closed. ``why`` says why it is not open just now.

    Raises:
        InputError: the port cannot be opened the first time.
    """

    def __init__(self, name: str, baudrate: int, talk: Talk, ring: Ring, once: bool = False) -> None:
        self.unplugged = 0
        self.why = ""
        self._name, self._baudrate, self._talk, self._ring = name, baudrate, talk, ring
        self._once = once
        self._stop = threading.Event()
        self._port = open_port(name, baudrate)
        self.epoch = Epoch.now()
        self._thread = threading.Thread(target=self._run, name=f"port {name}", daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def ask_tare(self) -> None:
        """Put a request for a tare into the stream, where a recording keeps it."""
        self._note(TARE)

    def close(self) -> None:
        """Stop reading and let go of the port; the ring is closed after the last chunk."""
        self._stop.set()
        if self._thread.ident is None:  # it never began
            self._port.close()
        else:
            self._thread.join()

    def _note(self, text: str) -> None:
        self._ring.put(Chunk(time.monotonic_ns() - self.epoch.monotonic, note=text))

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._note(PLUGGED)
                try:
                    self._read()
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
            self._ring.close()

    def _read(self) -> None:
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
            if data:
                self._ring.put(Chunk(time.monotonic_ns() - self.epoch.monotonic, data))

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
