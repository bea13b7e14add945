"""Drained port: starts the drain process of a serial port, passes it the port, and receives its records."""

import contextlib
import socket
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tactile.serial import drain
from tactile.wire.base import Talk

if TYPE_CHECKING:
    import serial

MOST = 2**20
"""Bytes per receive."""


class Drained:
    """The reader's end of `drain.Drain`. ``over``: nothing more will come."""

    def __init__(self) -> None:
        self.over = False
        self._received = bytearray()
        self._socket, theirs = socket.socketpair()
        with theirs:
            # its own session: no signals of the terminal, and its own share of the processors
            self._process = subprocess.Popen(
                [sys.executable, "-E", "-s", "-S", str(Path(drain.__file__)), str(theirs.fileno())],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, pass_fds=[theirs.fileno()], start_new_session=True,
            )  # fmt: skip

    def read(self, port: "serial.Serial", talk: Talk) -> None:
        """Pass an open port to the process, with the bytes to send on it."""
        order = drain.ORDER.pack(len(talk.hello), len(talk.poll), talk.period) + talk.hello + talk.poll
        with contextlib.suppress(OSError):  # `take` reports the end
            socket.send_fds(self._socket, [order], [port.fileno()])

    def take(self, timeout: float) -> list[tuple[int, int, bytes]]:
        """Return the available records (kind, time [ns], bytes); wait up to ``timeout`` [s] for the first."""
        self._socket.settimeout(timeout)
        try:
            data = self._socket.recv(MOST)
            self.over = not data
        except (TimeoutError, BlockingIOError):
            return []
        except OSError:
            self.over = True
            return []
        self._received += data
        return self._records()

    def _records(self) -> list[tuple[int, int, bytes]]:
        found, at, there = [], 0, self._received
        while len(there) >= at + drain.RECORD.size:
            kind, t, length = drain.RECORD.unpack_from(there, at)
            end = at + drain.RECORD.size + length
            if len(there) < end:
                break
            found.append((kind, t, bytes(there[at + drain.RECORD.size : end])))
            at = end
        del there[:at]
        return found

    def finish(self) -> None:
        """Ask the process to send its buffer and end."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        """Wait for the end of the process."""
        self.finish()
        self._socket.close()
        self._process.wait()
