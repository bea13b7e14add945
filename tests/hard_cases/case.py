"""A hard case: what is computed, the exact answer, how far it may be off, and what the naive form gives."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from cnnsim.backends.base import Backend
from cnnsim.support import Array

Compute = Callable[[Backend], Array]


@dataclass(frozen=True)
class HardCase:
    """One case of a family.

    ``ours`` computes on a backend, ``exact`` is the answer in high precision or in closed form; their largest
    difference must be at most ``bound`` (``bound32`` in float32). ``naive`` is the form one would write first; where
    ``naive_fails`` it must be off by more than the bound, else within it. ``refused``: part of the message instead.
    ``again``: another run of ours, whose bytes must be the same, instead of an exact answer.
    ``slow``: only the compiled loops of the cpu backend take less than seconds. ``page``: `make hard-cases` alone runs
    it, for it takes longer than a test may.
    """

    name: str
    why: str
    ours: Compute
    exact: Callable[[], Array] | None = None
    bound: float = 1e-11
    bound32: float = 1e-4
    naive: Callable[[], Array] | None = None
    naive_fails: bool = True
    refused: str = ""
    slow: bool = False
    page: bool = False
    again: Compute | None = None

    def __post_init__(self) -> None:
        if self.exact is not None:  # of one answer in high precision, which every backend is held to
            object.__setattr__(self, "exact", cache(self.exact))

    def truth(self, backend: Backend) -> Array:
        """Return what ours must be."""
        if self.again is not None:
            return self.again(backend)
        assert self.exact is not None
        return self.exact()
