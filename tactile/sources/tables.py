"""Taking keys out of hand-written TOML tables, with errors that name the file, the table and the key."""

import difflib
from collections.abc import Mapping
from typing import Any, TypeVar, cast

import numpy as np

from cnnsim.errors import InputError
from tactile.frame import Quantity, TaxelArray

Kind = TypeVar("Kind")
REQUIRED = object()
"""The default of a key that must be there."""


def check_keys(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    """Refuse keys that nobody reads, naming the nearest one that is read.

    Raises:
        InputError: an unknown key.
    """
    for key in table:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
            raise InputError(f"{where}: unknown key {key!r}; {hint}")


def take(table: Mapping[str, Any], key: str, kind: type[Kind], where: str, default: Any = REQUIRED) -> Kind:
    """Return the value of ``key``, a whole number standing for a float where a float is wanted.

    Raises:
        InputError: the key is missing without a default, or of another type, or a number that is not finite.
    """
    if key not in table:
        if default is REQUIRED:
            raise InputError(f"{where}: key {key!r} is missing, {_named(kind)} wanted")
        value = default
    else:
        value = table[key]
    if kind is float and type(value) is int:
        value = float(value)
    if not isinstance(value, kind) or type(value) is not kind:  # a bool is an int to isinstance
        raise InputError(f"{where}: {key} = {value!r}, {_named(kind)} wanted")
    if isinstance(value, float) and not np.isfinite(value):
        raise InputError(f"{where}: {key} = {value!r}, {_named(kind)} wanted")
    return value


def take_numbers(table: Mapping[str, Any], key: str, count: int, where: str, default: Any = REQUIRED) -> list[float]:
    """Return a list of ``count`` finite numbers.

    Raises:
        InputError: as ``take``, or another number of entries.
    """
    return numbers(take(table, key, list, where, default), count, f"{where}: {key}")


def numbers(values: Any, count: int, where: str) -> list[float]:
    """Return ``values`` as ``count`` finite floats.

    Raises:
        InputError: no list of that length, or an entry that is no finite number.
    """
    if (
        not isinstance(values, list)
        or len(values) != count
        or not all(type(v) in (int, float) and np.isfinite(v) for v in values)
    ):
        raise InputError(f"{where} = {values!r}, a list of {count} finite numbers wanted")
    return [float(v) for v in values]


def take_tables(table: Mapping[str, Any], key: str, where: str) -> list[dict[str, Any]]:
    """Return the tables under [[key]], none where there are none.

    Raises:
        InputError: something else than tables stands there.
    """
    tables = table.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(entry, dict) for entry in tables):
        raise InputError(f"{where}: {key!r} is {tables!r}, [[{key}]] tables wanted")
    return tables


def take_array(
    table: Mapping[str, Any], pitch: float, depth: float, origin: list[float], quantity: str, where: str
) -> TaxelArray:
    """Return the taxel array with the table's ``name``, ``rows`` and ``cols``, lengths in [m].

    Raises:
        InputError: as ``take`` and ``TaxelArray``.
    """
    name, rows, cols = (take(table, "name", str, where), *(take(table, key, int, where) for key in ("rows", "cols")))
    try:
        return TaxelArray(name, rows, cols, pitch, depth, (origin[0], origin[1]), cast(Quantity, quantity))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _named(kind: type) -> str:
    names = {float: "a finite number", int: "a whole number", str: "a text", list: "a list", dict: "a table"}
    return names[kind]
