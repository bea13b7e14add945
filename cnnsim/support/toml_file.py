"""Reads TOML files that people write by hand, and takes keys out of their tables: errors name file, table and key."""

import sys
import tomllib
from collections.abc import Collection, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from cnnsim.support.errors import InputError

ValueType = TypeVar("ValueType")
REQUIRED = object()
"""The default of a key that must be there."""


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table of a file; ``what`` says in messages what it should be.

    Raises:
        InputError: no such file, one that cannot be read, no TOML.
    """
    try:
        return parse_toml(path.read_text(encoding="utf-8"), str(path))
    except FileNotFoundError as error:
        raise InputError(f"no {what} {path}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a {what}: {error}") from error


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the table of a text.

    Raises:
        InputError: no TOML.
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # numbers of 4300 digits; brackets nested 1000 deep
        raise InputError(f"{where}: not TOML: {error}") from error


def check_keys(
    table: Mapping[str, Any], known: Collection[str], where: str = "", required: Collection[str] = ()
) -> None:
    """Refuse keys that are not known, naming the nearest ones, and tables without required ones: all at once.

    Raises:
        InputError: no table, an unknown key, or a missing one.
    """
    lead = f"{where}: " if where else ""
    if not isinstance(table, Mapping):
        raise InputError(f"{lead}{table!r}, a table wanted")
    found: list[str] = []
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, 1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
            found.append(f"unknown key {key!r}; {hint}")
    missing = [key for key in required if key not in table]
    if missing:
        found.append(f"no {', '.join(map(repr, missing))}")
    if found:
        raise InputError(f"{lead}{'; '.join(found)}")


def in_range(number: float) -> bool:
    """Return whether a number is finite and, if it is a whole one, a float can hold it."""
    return -sys.float_info.max <= number <= sys.float_info.max


def take(table: Mapping[str, Any], key: str, kind: type[ValueType], where: str, default: Any = REQUIRED) -> ValueType:
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
    if kind is float and type(value) is int and in_range(value):
        value = float(value)
    if not isinstance(value, kind) or type(value) is not kind:  # a bool is an int to isinstance
        raise InputError(f"{where}: {key} = {value!r}, {_named(kind)} wanted")
    if isinstance(value, float) and not in_range(value):
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
        or not all(type(v) in (int, float) and in_range(v) for v in values)
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


def _named(kind: type) -> str:
    names = {float: "a finite number", int: "a whole number", str: "a text", list: "a list", dict: "a table",
             bool: "true or false"}  # fmt: skip
    return names[kind]
