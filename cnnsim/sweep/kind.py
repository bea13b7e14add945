"""Kind of sweep: the keys of a case, the function that runs cases, and which cases run in one call."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from cnnsim.support import InputError

Case = Mapping[str, Any]
"""The values of one case by key."""
Row = dict[str, Any]
"""The results of one case by column: numbers, texts and booleans."""


@dataclass(frozen=True)
class Kind:
    """One kind of sweep, the constant ``KIND`` of its module.

    ``keys`` has the keys of a case with their descriptions, ``needed`` the required ones. ``run`` takes cases and
    returns a row for each, in order; if it raises, the cases are run one by one. ``group``: cases with the same value
    are run in one call (None: each by itself). ``check`` checks each case before any is run. ``paths``: keys whose
    values are files, relative to the folder of the sweep's file.
    """

    keys: Mapping[str, str]
    run: Callable[[Sequence[Case]], Sequence[Row]]
    group: Callable[[Case], Hashable] | None = None
    needed: Sequence[str] = ()
    check: Callable[[Case], None] | None = None
    paths: Sequence[str] = ()


def load_kind(name: str, kinds: Mapping[str, str]) -> Kind:
    """Return the kind called ``name``; ``kinds`` has the module of each.

    Raises:
        InputError: no kind of that name.
    """
    if not isinstance(name, str) or name not in kinds:
        raise InputError(f"kind {name!r} of sweep; one of {', '.join(kinds)} wanted")
    kind = import_module(kinds[name]).KIND
    assert isinstance(kind, Kind)
    return kind
