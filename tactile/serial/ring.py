"""Bounded queue between two threads: giving never waits, and what finds no place is counted."""

import threading
from collections import deque

from tactile.wire.source import Chunk

CAPACITY = 64 * 2**20
"""Bytes kept for a reader that is behind: more than a minute of a 1000 Hz array of 64 taxels."""
CHUNK_COST = 64
"""Bytes that a chunk counts beside its data, so that empty ones are bounded, too."""


class Ring:
    """Chunks in, chunks out. One that finds no room is dropped: the newest goes, so that what is kept is unbroken."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self.overflowed = 0
        self._capacity, self._used = capacity, 0
        self._chunks: deque[Chunk] = deque()
        self._wake = threading.Condition()
        self._closed = False

    def put(self, chunk: Chunk) -> bool:
        """Take a chunk at once, or count its bytes as overflowed and return False. Notes always find room."""
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
        """Return all chunks there are, waiting up to ``timeout`` [s] for the first."""
        with self._wake:
            if timeout and not self._chunks and not self._closed:
                self._wake.wait(timeout)
            chunks = list(self._chunks)
            self._chunks.clear()
            self._used = 0
        return chunks

    def close(self) -> None:
        """Let `get` return at once from now on."""
        with self._wake:
            self._closed = True
            self._wake.notify_all()

    @property
    def closed(self) -> bool:
        """Whether nothing more will come."""
        return self._closed
