"""Drained port: starts the drain process of a serial port, passes it the port, and receives its records."""

import contextlib
import select
import subprocess
import sys
from multiprocessing import Pipe
from multiprocessing.reduction import send_handle
from pathlib import Path
from typing import TYPE_CHECKING

from tactile.serial import drain
from tactile.wire.base import Talk

if TYPE_CHECKING:
    import serial

MOST = 1024
"""Records taken at once."""


class Drained:
    """The reader's end of `drain.Drain`. ``over``: nothing more will come."""

    def __init__(self) -> None:
        self.over = False
        self._link, theirs = Pipe()
        self._ready = select.poll()  # quicker than the connection's own poll
        self._ready.register(self._link.fileno(), select.POLLIN)
        with theirs:
            # its own session: no signals of the terminal, and its own share of the processors
            self._process = subprocess.Popen(
                [sys.executable, "-E", "-s", "-S", str(Path(drain.__file__)), str(theirs.fileno())],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, pass_fds=[theirs.fileno()], start_new_session=True,
            )  # fmt: skip

    def read(self, port: "serial.Serial", talk: Talk) -> None:
        """Pass an open port to the process, with the bytes to send on it."""
        with contextlib.suppress(OSError):  # `take` reports the end
            self._link.send_bytes(drain.ORDER.pack(len(talk.hello), talk.period) + talk.hello + talk.poll)
            send_handle(self._link, port.fileno(), self._process.pid)

    def take(self, timeout: float) -> list[tuple[int, int, bytes]]:
        """Return the available records (kind, time [ns], bytes); wait up to ``timeout`` [s] for the first."""
        records: list[tuple[int, int, bytes]] = []
        try:
            while len(records) < MOST and self._ready.poll(0 if records else 1e3 * timeout):
                record = self._link.recv_bytes()
                records.append((*drain.RECORD.unpack_from(record), record[drain.RECORD.size :]))
        except (EOFError, OSError):
            self.over = True
        return records

    def finish(self) -> None:
        """Ask the process to send its buffer and end."""
        with contextlib.suppress(OSError):
            self._link.send_bytes(b"")

    def close(self) -> None:
        """Wait for the end of the process."""
        self._link.close()
        self._process.wait()
