"""Drain process of a serial port: reads, time-stamps and buffers bytes until the reader takes them.

The pipeline may be delayed by the scheduler or by its own threads, while a terminal buffers only a few milliseconds of
bytes. This process does nothing else, so no byte is lost. It runs as a script and imports only light modules.

Protocol on a socket. In: a header, the hello, the poll, and the file descriptor of the open port. Out: records of kind,
time [ns] of the monotonic clock, length, and bytes. When the reader closes its side the process sends its buffer and
ends.
"""

import contextlib
import os
import select
import signal
import socket
import struct
import sys
import time

ORDER = struct.Struct("<IId")
"""Length of the hello, length of the poll, period of the polls [s]; then both."""
RECORD = struct.Struct("<BqI")
"""kind, time [ns], length; then the bytes."""
DATA, GONE, DROPPED = 0, 1, 2
"""Kinds: bytes of the port; failure of the port with its reason; number of dropped bytes, as decimal digits."""
CAPACITY = 64 * 2**20
"""Buffer size in bytes: more than a minute of a 1000 Hz array of 64 taxels."""
MOST = 65536
FULL = 4000
"""Bytes per read of a terminal that has more."""


class Drain:
    """Reads one port after another and forwards records as fast as the reader takes them."""

    def __init__(self, reader: socket.socket) -> None:
        self._reader = reader
        self._port = -1
        self._poll, self._period, self._asked = b"", 0.0, 0.0
        self._pending, self._dropped = bytearray(), 0
        self._events = select.poll()
        reader.setblocking(False)

    def run(self) -> None:
        """Run until the reader closes its side or is gone."""
        self._events.register(self._reader, select.POLLIN)
        while True:
            for number, event in self._events.poll(self._wait()):
                if number == self._port:
                    self._read()
                elif event & (select.POLLIN | select.POLLHUP) and not self._take_order():
                    self._finish()
                    return
            self._ask()
            self._push()

    def _wait(self) -> float | None:
        """Return the time to the next poll [ms], None without polling."""
        if self._port < 0 or not self._poll:
            return None
        return max(0.0, 1e3 * (self._asked + self._period - time.monotonic()))

    def _take_order(self) -> bool:
        """Accept a port to read; return False when the reader has closed its side."""
        try:
            order, ports, _, _ = socket.recv_fds(self._reader, MOST, 1)
        except OSError:
            return False
        if not order:
            return False
        hello, _, self._period = ORDER.unpack_from(order)
        self._poll, self._asked = order[ORDER.size + hello :], 0.0
        (self._port,) = ports
        self._events.register(self._port, select.POLLIN)
        self._say(order[ORDER.size : ORDER.size + hello])
        return True

    def _ask(self) -> None:
        if self._port >= 0 and self._poll and time.monotonic() >= self._asked + self._period:
            self._asked = time.monotonic()
            self._say(self._poll)

    def _say(self, words: bytes) -> None:
        try:
            os.write(self._port, words)
        except BlockingIOError:
            pass  # the device does not read
        except OSError as error:
            self._let_go(error)

    def _read(self) -> None:
        data = b""
        try:
            while True:
                piece = os.read(self._port, MOST)
                data += piece
                if not piece and not data:
                    raise OSError("the device is gone")
                if len(piece) < FULL or len(data) > MOST:
                    break
        except BlockingIOError:
            pass
        except OSError as error:
            self._keep(DATA, data)
            self._let_go(error)
            return
        self._keep(DATA, data)

    def _let_go(self, error: OSError) -> None:
        self._events.unregister(self._port)
        os.close(self._port)
        self._port = -1
        self._keep(GONE, str(error).encode())

    def _keep(self, kind: int, data: bytes) -> None:
        if kind == DATA and len(self._pending) + len(data) > CAPACITY:
            self._dropped += len(data)
            return
        now = time.monotonic_ns()
        if self._dropped:
            said, self._dropped = b"%d" % self._dropped, 0
            self._pending += RECORD.pack(DROPPED, now, len(said)) + said
        if data or kind == GONE:
            self._pending += RECORD.pack(kind, now, len(data)) + data

    def _push(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while self._pending:
                del self._pending[: self._reader.send(self._pending[:MOST])]
        self._events.modify(self._reader, select.POLLIN | (select.POLLOUT if self._pending else 0))

    def _finish(self) -> None:
        """Read the rest of the bytes, and send the buffer."""
        if self._port >= 0 and self._events.poll(0):
            self._read()
        if self._port >= 0:
            os.close(self._port)
        self._keep(DATA, b"")
        with contextlib.suppress(OSError):
            self._reader.setblocking(True)
            self._reader.sendall(self._pending)


def main() -> None:
    """Serve the socket whose file descriptor is the only argument."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        signal.signal(getattr(signal, name), signal.SIG_IGN)  # the reader ends this process
    with contextlib.suppress(OSError, AttributeError):  # real-time priority, where permitted
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    with socket.socket(fileno=int(sys.argv[1])) as reader, contextlib.suppress(BrokenPipeError, ConnectionError):
        Drain(reader).run()


if __name__ == "__main__":
    main()
