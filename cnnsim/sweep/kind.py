"""Kind of sweep: what one case is, which keys it has, which cases share a launch, and the function that runs them."""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from time import perf_counter
from typing import Any

from cnnsim.support import InputError

Case = Mapping[str, Any]
"""What is chosen in one case: the keys of a kind with their values."""
Row = dict[str, Any]
"""What came out of one case: numbers, texts and truth values by column."""


@dataclass(frozen=True)
class Kind:
    """One kind of sweep; a module has it as ``KIND``, and a registry the module's name.

    ``keys``: what a case may choose, each with a word on it; ``needed``: those it must. ``run`` takes cases and gives
    a row for each, in order; it may raise on any of them, and is then run on parts until the one is found. ``group``:
    cases for which it gives the same are run together in one launch (None: each by itself). ``check`` looks at each
    case before any is run. ``paths``: keys whose values are files, meant from the folder of the sweep's file.
    """

    keys: Mapping[str, str]
    run: Callable[[Sequence[Case]], Sequence[Row]]
    group: Callable[[Case], Hashable] | None = None
    needed: Sequence[str] = ()
    check: Callable[[Case], None] | None = None
    paths: Sequence[str] = field(default=())


def load_kind(name: str, kinds: Mapping[str, str]) -> Kind:
    """Return the kind called ``name``; ``kinds`` has the module of each.

    Raises:
        InputError: there is none of that name.
    """
    if not isinstance(name, str) or name not in kinds:
        raise InputError(f"kind {name!r} of sweep; one of {', '.join(kinds)} wanted")
    kind = import_module(kinds[name]).KIND
    assert isinstance(kind, Kind)
    return kind


class _Kernels:
    seconds = 0.0


@contextmanager
def in_kernels() -> Iterator[None]:
    """Count the seconds of a block as computing: everything else of a job is overhead, which a summary tells."""
    begun = perf_counter()
    try:
        yield
    finally:
        _Kernels.seconds += perf_counter() - begun


def kernel_seconds() -> float:
    """Return the seconds of this process that `in_kernels` has counted."""
    return _Kernels.seconds
