"""Bounded queue between two threads: put never waits, and dropped chunks are counted."""

import threading
from collections import deque

from tactile.wire.source import Chunk

CAPACITY = 64 * 2**20
"""Queue size in bytes: more than a minute of a 1000 Hz array of 64 taxels."""
CHUNK_COST = 64
"""Overhead per chunk in bytes, which bounds the number of empty chunks."""


class Ring:
    """A bounded queue of chunks. The newest chunk is dropped when it is full, so that the queue has no gaps."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self.overflowed = 0
        self._capacity, self._used = capacity, 0
        self._chunks: deque[Chunk] = deque()
        self._wake = threading.Condition()
        self._closed = False

    def put(self, chunk: Chunk) -> bool:
        """Append a chunk, or count its bytes as overflowed and return False. Notes are never dropped."""
        cost = len(chunk.data) + CHUNK_COST
        with self._wake:
            if chunk.data and self._used + cost > self._capacity:
                self.overflowed += len(chunk.data)
                return False
            self._chunks.append(chunk)
            self._used += cost
            self._wake.notify()
        return True

    def get(self, timeout: float) -> list[Chunk]:
        """Return all chunks; wait up to ``timeout`` [s] for the first."""
        with self._wake:
            if timeout and not self._chunks and not self._closed:
                self._wake.wait(timeout)
            chunks = list(self._chunks)
            self._chunks.clear()
            self._used = 0
        return chunks

    def close(self) -> None:
        """Make `get` return at once from now on."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()

    @property
    def closed(self) -> bool:
        """Whether nothing more will come."""
        return self._closed
