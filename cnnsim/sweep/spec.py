"""Sweep files: the choices of each key, read from TOML and multiplied out to cases."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import naming
from cnnsim.support.toml_file import check_keys, located, read_toml, take
from cnnsim.sweep.kind import Case, Kind, load_kind

MOST_CASES = 10**8
"""The most cases of a sweep."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """A grid of cases of one kind: case k is the k-th combination, the last key of ``grid`` changing fastest."""

    kind: Kind
    module: str
    grid: Mapping[str, tuple[Any, ...]]
    fixed: Mapping[str, Any]
    name: str

    def __len__(self) -> int:
        return math.prod(len(values) for values in self.grid.values())

    def case(self, number: int) -> dict[str, Any]:
        """Return the values of case ``number`` by key."""
        chosen: dict[str, Any] = {}
        for key in reversed(list(self.grid)):
            number, at = divmod(number, len(self.grid[key]))
            chosen[key] = self.grid[key][at]
        return {**self.fixed, **{key: chosen[key] for key in self.grid}}

    @property
    def digest(self) -> str:
        """The checksum of its module, its grid and its fixed values."""
        return sha256(json.dumps([self.module, list(self.grid.items()), dict(self.fixed)]).encode()).hexdigest()


def read_sweep(path: Path, kinds: Mapping[str, str]) -> Sweep:
    """Read a sweep's file: ``kind``, [grid] with a list or a range for each key, and [fixed]; all cases are checked.

    A range is { from = 0, count = 100 }, { from = 0.1, to = 0.9, count = 9 }, or with spacing = "log".

    Raises:
        InputError: unknown keys or kinds, keys given twice, no case, a case that cannot be.
    """
    table = read_toml(path, "sweep")
    faults = ErrorList(str(path))
    faults.check(table, ("kind", "grid", "fixed"), required=("kind", "grid"))
    kind, values, chosen = _parts(table, kinds, faults)
    faults.raise_all()
    assert kind is not None
    with naming(path):
        for key in kind.paths:
            if key in values:
                values[key] = tuple(_beside(path, value) for value in values[key])
            if key in chosen:
                chosen[key] = _beside(path, chosen[key])
        sweep = Sweep(kind, kinds[table["kind"]], values, chosen, path.stem)
        if not 0 < len(sweep) <= MOST_CASES:
            raise InputError(f"{len(sweep)} cases; 1 to {MOST_CASES:.0e} wanted")
        _check(sweep)
    return sweep


def _parts(
    table: Mapping[str, Any], kinds: Mapping[str, str], faults: ErrorList
) -> tuple[Kind | None, dict[str, tuple[Any, ...]], dict[str, Any]]:
    """Return the kind (None if unknown), the list of values of each key of [grid], and the values of [fixed]."""
    kind: Kind | None = None
    if "kind" in table:
        with faults.collecting(), located(table, "kind"):
            kind = load_kind(table["kind"], kinds)
    grid: dict[str, Any] = {}
    fixed: dict[str, Any] = {}
    with faults.collecting():
        grid = take(table, "grid", dict, "sweep", {})
    with faults.collecting():
        fixed = take(table, "fixed", dict, "sweep", {})
    if kind is not None:
        for part, name in ((grid, "[grid]"), (fixed, "[fixed]")):
            faults.check(part, kind.keys, name)
        missing = [key for key in kind.needed if key not in grid and key not in fixed]
        with faults.collecting(), located(grid):
            if missing and "grid" in table:
                raise InputError(f"no {', '.join(map(repr, missing))} in [grid] or [fixed]")
    with faults.collecting(), located(fixed):
        if twice := grid.keys() & fixed.keys():
            raise InputError(f"{', '.join(sorted(twice))} in [grid] and in [fixed]; one of them wanted")
    values: dict[str, tuple[Any, ...]] = {}
    for key in grid:
        with faults.collecting():
            values[key] = _values(grid, key)
    return kind, values, {key: _plain(value) for key, value in fixed.items()}


def _check(sweep: Sweep) -> None:
    """Check each value of each key once, with the first values of the other keys."""
    if sweep.kind.check is None:
        return
    first: Case = sweep.case(0)
    faults = ErrorList()
    with faults.collecting():
        sweep.kind.check(first)
    for key, values in sweep.grid.items():
        for value in values[1:]:
            with faults.collecting():
                sweep.kind.check({**first, key: value})
    faults.raise_all()


def _values(grid: Mapping[str, Any], key: str) -> tuple[Any, ...]:
    value, where = grid[key], f"[grid]: {key}"
    with located(grid, key):
        if isinstance(value, dict):
            return _range(value, where)
        if not isinstance(value, list) or not value:
            raise InputError(f"{where} = {value!r}; a list of values, or a range with from and count, wanted")
        return tuple(_plain(entry) for entry in value)


def _range(table: Mapping[str, Any], where: str) -> tuple[Any, ...]:
    check_keys(table, ("from", "to", "count", "spacing"), where, required=("from", "count"))
    count, spacing = take(table, "count", int, where), take(table, "spacing", str, where, "linear")
    if not 0 < count <= MOST_CASES:
        raise InputError(f"{where}: count = {count}; 1 to {MOST_CASES:.0e} wanted")
    if "to" not in table:
        if spacing != "linear":
            raise InputError(f"{where}: spacing = {spacing!r} without 'to'; both wanted")
        first = take(table, "from", int, where)
        return tuple(range(first, first + count))
    low, high = take(table, "from", float, where), take(table, "to", float, where)
    if spacing == "linear":
        return tuple(float(f"{value:.12g}") for value in np.linspace(low, high, count))
    if spacing != "log" or not (low > 0 and high > 0):
        raise InputError(f"{where}: spacing = {spacing!r} from {low:g} to {high:g}; linear, or log above 0, wanted")
    return tuple(float(f"{value:.12g}") for value in np.geomspace(low, high, count))


def _plain(value: Any) -> Any:
    """Return tables and lists of a file as plain ones, for other processes and the checksum."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, list) else value


def _beside(path: Path, value: Any) -> Any:
    if not isinstance(value, str) or not (path.parent / value).exists():
        return value  # a name of the library, say; a missing file is found by the kind's own check
    return str((path.parent / value).resolve())
