"""Reads TOML files that people write by hand, and takes keys out of their tables: errors name file, table and key."""

import re
import stat
import sys
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, TypeVar

from cnnsim.support.errors import InputError, MissingKeyError, nearest, reworded, shown
from cnnsim.support.limits import TEXT, check_file, check_most, reason
from cnnsim.support.toml_lines import LinedTable, with_lines

ValueType = TypeVar("ValueType")
_WITH_LINE = re.compile(r"\(lines? \d+|, line \d+")
MOST_FAULTS = 20
"""Faults of a file that are told at once: who has mended those sees the others."""
REQUIRED = object()
"""The default of a key that must be there."""


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table of a file; ``what`` says in messages what it should be.

    Raises:
        InputError: no such file, one that cannot be read, no TOML.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe would be waited for until somebody writes into it
            kind = "a folder" if path.is_dir() else "no regular file"
            raise InputError(f"{path}: {kind}; a {what} wanted")
        check_file(path, what, TEXT)
        return parse_toml(path.read_text(encoding="utf-8-sig"), str(path))
    except FileNotFoundError as error:
        raise InputError(f"no {what} {path}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a {what}: {reason(error)}") from error


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the table of a text.

    Raises:
        InputError: no TOML.
    """
    try:
        check_most(len(text), TEXT, "characters")
        return with_lines(tomllib.loads(text), text)
    except (ValueError, RecursionError, MemoryError) as error:  # numbers of 4300 digits; brackets nested 1000 deep
        raise InputError(f"{where}: not TOML: {error}") from error


def line_of(table: Any, key: str | None = None) -> str:
    """Return " (line 7)" for a key of a table, or for the table; nothing for one that was not read from a file."""
    if not isinstance(table, LinedTable):
        return ""
    line = table.line if key is None else table.lines.get(key, table.line)
    return "" if line is None else f" (line {line})"


class located:  # noqa: N801 - it reads as a word after "with", as `naming` does
    """End the message of an InputError with the line of a table, or of one of its keys, if it names none yet."""

    __slots__ = ("_line",)

    def __init__(self, table: Any, key: str | None = None) -> None:
        self._line = line_of(table, key)

    def __enter__(self) -> None: ...

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if isinstance(error, InputError) and self._line:
            raise reworded(error, lambda text: text if _WITH_LINE.search(text) else text + self._line) from error


def check_keys(
    table: Mapping[str, Any], known: Collection[str], where: str = "", required: Collection[str] = ()
) -> None:
    """Refuse keys that are not known, naming the nearest ones, and tables without required ones: all at once.

    Raises:
        InputError: no table, an unknown key, or a missing one.
    """
    lead = f"{where}: " if where else ""
    if not isinstance(table, Mapping):
        raise InputError(f"{lead}{shown(table)}, a table wanted")
    found: list[str] = []
    far: list[str] = []
    for key in table:
        if key not in known:
            near = nearest(key, known)
            place = f"{shown(key)}{line_of(table, key)}"
            if near:
                found.append(f"unknown key {place}; did you mean {near!r}?")
            else:
                far.append(place)
    if far:
        more = f" and {len(far) - MOST_FAULTS} more" * (len(far) > MOST_FAULTS)
        some = ", ".join(far[:MOST_FAULTS]) + more
        found.append(f"unknown key{'s' * (len(far) > 1)} {some}; known are {', '.join(known)}")
    missing = [key for key in required if key not in table]
    if missing:
        found.append(f"no {', '.join(map(repr, missing))}{_room(table)}")
    if found:
        raise InputError(f"{lead}{'; '.join(found)}")


def _room(table: Mapping[str, Any]) -> str:
    """Return where missing keys belong: those of a file before its first table."""
    if not isinstance(table, LinedTable) or table.line is not None:
        return line_of(table)
    if table.first_table is None:
        return f" (line {max(table.lines.values(), default=0) + 1} is free)"
    return f" (wanted before the first table, line {table.first_table})"


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
            raise MissingKeyError(f"{where}: key {key!r} is missing, {_named(kind)} wanted{line_of(table)}")
        value = default
    else:
        value = table[key]
    if kind is float and type(value) is int and in_range(value):
        value = float(value)
    right = isinstance(value, kind) and (type(value) in (kind, LinedTable))  # a bool is an int to isinstance
    if not right or (isinstance(value, float) and not in_range(value)):
        raise InputError(f"{where}: {key} = {shown(value)}, {_named(kind)} wanted{line_of(table, key)}")
    return value


def take_positive(table: Mapping[str, Any], key: str, where: str, default: Any = REQUIRED) -> float:
    """Return a number above 0.

    Raises:
        InputError: as ``take``, or one that is not.
    """
    value = take(table, key, float, where, default)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value}, a positive number wanted{line_of(table, key)}")
    return value


def take_from_zero(table: Mapping[str, Any], key: str, where: str, default: Any = REQUIRED) -> float:
    """Return a number from 0 up.

    Raises:
        InputError: as ``take``, or one below 0.
    """
    value = take(table, key, float, where, default)
    if value < 0:
        raise InputError(f"{where}: {key} = {value}, a number from 0 up wanted{line_of(table, key)}")
    return value


def take_numbers(table: Mapping[str, Any], key: str, count: int, where: str, default: Any = REQUIRED) -> list[float]:
    """Return a list of ``count`` finite numbers.

    Raises:
        InputError: as ``take``, or another number of entries.
    """
    with located(table, key):
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
        raise InputError(f"{where} = {shown(values)}, a list of {count} finite numbers wanted")
    return [float(v) for v in values]


def take_duration(table: Mapping[str, Any], where: str) -> Any:
    """Return the key ``duration``: "settled", or a number of time constants from 0 on.

    Raises:
        InputError: anything else.
    """
    value = table["duration"]
    if value == "settled" or (type(value) in (int, float) and in_range(value) and value >= 0):
        return value
    wanted = "'settled' or a number of time constants >= 0 wanted"
    raise InputError(f"{where}: duration = {shown(value)}, {wanted}{line_of(table, 'duration')}")


def take_tables(table: Mapping[str, Any], key: str, where: str) -> list[dict[str, Any]]:
    """Return the tables under [[key]], none where there are none.

    Raises:
        InputError: something else than tables stands there.
    """
    tables = table.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(entry, dict) for entry in tables):
        raise InputError(f"{where}: {key!r} is {shown(tables)}, [[{key}]] tables wanted{line_of(table, key)}")
    return tables


def _named(kind: type) -> str:
    names = {float: "a finite number", int: "a whole number", str: "a text", list: "a list", dict: "a table",
             bool: "true or false"}  # fmt: skip
    return names[kind]
