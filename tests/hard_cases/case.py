"""A hard case: the computation, the exact answer, the bound of the error, and the naive form."""

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
    difference must be at most ``bound`` (``bound32`` in float32). ``naive`` is the straightforward computation; with
    ``naive_fails`` its error must exceed the bound, otherwise not. ``refused``: part of the message expected instead of
    a result. ``again``: a second run that must give the same bytes, instead of an exact answer. ``slow``: only the
    compiled loops of the cpu backend need less than seconds. ``page``: only `make hard-cases` runs it: it is too slow
    for a test.
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
        if self.exact is not None:  # one answer in high precision for all backends
            object.__setattr__(self, "exact", cache(self.exact))

    def truth(self, backend: Backend) -> Array:
        """Return the expected answer of ``ours``."""
        if self.again is not None:
            return self.again(backend)
        assert self.exact is not None
        return self.exact()
