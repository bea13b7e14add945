"""Drain process of a serial port: reads, time-stamps and buffers bytes until the reader takes them.

The pipeline may be delayed by the scheduler or by its own threads, while a terminal buffers only a few milliseconds of
bytes. This process does nothing else, so no byte is lost. It runs as a script and imports only the standard library.

Messages on its connection. In: a header, the hello, the poll, followed by the handle of the open port; or nothing, to
end. Out: kind, time [ns] of the monotonic clock, bytes. At the end it sends its buffer.
"""

import contextlib
import os
import select
import signal
import struct
import sys
import time
from collections import deque
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle

ORDER = struct.Struct("<Id")
"""Length of the hello, period of the polls [s]; then the hello and the poll."""
RECORD = struct.Struct("<Bq")
"""kind, time [ns]; then the bytes."""
DATA, GONE, DROPPED = 0, 1, 2
"""Kinds: bytes of the port; failure of the port with its reason; number of dropped bytes, as decimal digits."""
CAPACITY = 64 * 2**20
"""Buffer size in bytes: more than a minute of a 1000 Hz array of 64 taxels."""
MOST = 16384
"""Bytes per record, about: a connection that is ready takes them without waiting."""


class Drain:
    """Reads one port after another and sends records as fast as the reader takes them."""

    def __init__(self, reader: Connection) -> None:
        self._reader = reader
        self._port = -1
        self._poll, self._period, self._asked = b"", 0.0, 0.0
        self._records: deque[bytes] = deque()
        self._kept = self._dropped = 0  # bytes
        self._events = select.poll()

    def run(self) -> None:
        """Run until the reader requests the end or has ended."""
        link, running = self._reader.fileno(), True
        while running:
            self._events.register(link, select.POLLIN | (select.POLLOUT if self._records else 0))
            for number, event in self._events.poll(self._wait()):
                if number == self._port:
                    self._read()
                elif event & (select.POLLIN | select.POLLHUP):
                    running = self._take_order()
                else:
                    self._send()
            self._ask()
        self._events.unregister(link)
        while self._port >= 0 and self._kept < CAPACITY and self._events.poll(0):
            self._read()
        self._keep(DATA, b"")  # reports dropped bytes
        while self._records:
            self._send()

    def _send(self) -> None:
        record = self._records.popleft()
        self._kept -= len(record)
        self._reader.send_bytes(record)

    def _wait(self) -> float | None:
        """Return the time to the next poll [ms], None without polling."""
        if self._port < 0 or not self._poll:
            return None
        return max(0.0, 1e3 * (self._asked + self._period - time.monotonic()))

    def _take_order(self) -> bool:
        """Accept a port to read; return False at the end."""
        try:
            order = self._reader.recv_bytes()
            if not order:
                return False
            self._port = recv_handle(self._reader)
        except (EOFError, OSError, RuntimeError):
            return False
        length, self._period = ORDER.unpack_from(order)
        end = ORDER.size + length
        self._poll, self._asked = order[end:], 0.0
        self._events.register(self._port, select.POLLIN)
        self._write(order[ORDER.size : end])
        return True

    def _ask(self) -> None:
        if self._port >= 0 and self._poll and time.monotonic() >= self._asked + self._period:
            self._asked = time.monotonic()
            self._write(self._poll)

    def _write(self, request: bytes) -> None:
        try:
            os.write(self._port, request)
        except BlockingIOError:
            pass  # the device does not read
        except OSError as error:
            self._close_port(error)

    def _read(self) -> None:
        data, failure = b"", None
        try:
            data = piece = os.read(self._port, MOST)
            if not data:
                raise OSError("the device is gone")
            while piece and len(data) < MOST:  # a terminal gives 4 KiB at a time, and nothing when it is empty
                data += (piece := os.read(self._port, MOST))
        except BlockingIOError:
            pass
        except OSError as error:
            failure = error
        if self._kept + len(data) > CAPACITY:
            self._dropped += len(data)
        else:
            self._keep(DATA, data)
        if failure is not None:
            self._close_port(failure)

    def _close_port(self, error: OSError) -> None:
        self._events.unregister(self._port)
        os.close(self._port)
        self._port = -1
        self._keep(GONE, str(error).encode())

    def _keep(self, kind: int, data: bytes) -> None:
        if self._dropped:
            count, self._dropped = b"%d" % self._dropped, 0
            self._keep(DROPPED, count)
        if data or kind != DATA:
            record = RECORD.pack(kind, time.monotonic_ns()) + data
            self._kept += len(record)
            self._records.append(record)


def main() -> None:
    """Serve the connection whose file descriptor is the only argument."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        signal.signal(getattr(signal, name), signal.SIG_IGN)  # the reader ends this process
    with contextlib.suppress(OSError, AttributeError):  # real-time priority, where permitted
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    with Connection(int(sys.argv[1])) as reader, contextlib.suppress(ConnectionError):
        Drain(reader).run()


if __name__ == "__main__":
    main()
