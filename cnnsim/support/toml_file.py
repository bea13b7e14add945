"""TOML files that people write by hand: read with line numbers, and their keys checked and taken one by one.

`cnnsim.support.error_list.ErrorList` collects the errors of a whole file.
"""

import re
import sys
import tomllib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from cnnsim.support.errors import InputError, MissingKeyError, nearest, reworded, shown
from cnnsim.support.limits import TEXT, check_file, check_most, reason
from cnnsim.support.toml_lines import DEPTH, LinedTable, is_too_deep, with_lines

ValueType = TypeVar("ValueType")
_WITH_LINE = re.compile(r"\(lines? \d+|, line \d+")
MOST_FAULTS = 20
"""Errors of one file that are reported at once."""
REQUIRED = object()
"""The default of a key that has none."""
_KINDS = {float: "a finite number", int: "a whole number", str: "a text", list: "a list", dict: "a table",
          bool: "true or false"}  # fmt: skip


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table of a file; ``what`` names the kind of file in messages.

    Raises:
        InputError: no such file, not a plain file, not readable, too large, no TOML.
    """
    try:
        check_file(path, what, TEXT)
        return parse_toml(path.read_text(encoding="utf-8-sig"), str(path))
    except FileNotFoundError as error:
        raise InputError(f"no {what} {path}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a {what}: {reason(error)}") from error


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the table of a text, or raise an InputError that it is no TOML."""
    if is_too_deep(text):
        raise InputError(f"{where}: keys or brackets nested deeper than {DEPTH}; {DEPTH} at most wanted")
    try:
        check_most(len(text), TEXT, "characters")
        return with_lines(tomllib.loads(text), text)
    except (ValueError, RecursionError, MemoryError) as error:  # numbers of 4300 digits
        raise InputError(f"{where}: not TOML: {error}") from error


def line_of(table: Any, key: str | None = None) -> str:
    """Return " (line 7)" for a table or one of its keys; an empty text for one that was not read from a file."""
    if not isinstance(table, LinedTable):
        return ""
    line = table.line if key is None else table.lines.get(key, table.line)
    return "" if line is None else f" (line {line})"


class located:  # noqa: N801 - it reads as a word after "with", as `naming` does
    """Append the line of a table, or of one of its keys, to an InputError that has no line number yet."""

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
    """Refuse unknown keys, with the nearest known one, and missing keys: all in one InputError."""
    lead = f"{where}: " if where else ""
    if not isinstance(table, Mapping):
        raise InputError(f"{lead}{shown(table)}, a table wanted")
    places = {key: f"{shown(key)}{line_of(table, key)}" for key in table if key not in known}
    near = {key: nearest(key, known) for key in places}
    found = [f"unknown key {places[key]}; did you mean {word!r}?" for key, word in near.items() if word]
    far = [places[key] for key, word in near.items() if not word]
    if far:
        more = f" and {len(far) - MOST_FAULTS} more" * (len(far) > MOST_FAULTS)
        words = f"unknown key{'s' * (len(far) > 1)} {', '.join(far[:MOST_FAULTS])}{more}"
        found.append(f"{words}; known are {', '.join(known)}")
    missing = [repr(key) for key in required if key not in table]
    if missing:
        found.append(f"no {', '.join(missing)}{_room(table)}")
    if found:
        raise InputError(f"{lead}{'; '.join(found)}")


def _room(table: Mapping[str, Any]) -> str:
    """Return where missing keys belong: at the top of a file before its first table."""
    if not isinstance(table, LinedTable) or table.line is not None:
        return line_of(table)
    if table.first_table is None:
        return f" (line {max(table.lines.values(), default=0) + 1} is free)"
    return f" (wanted before the first table, line {table.first_table})"


def in_range(number: float) -> bool:
    """Return whether a number is finite and fits a float."""
    return -sys.float_info.max <= number <= sys.float_info.max


def take(table: Mapping[str, Any], key: str, kind: type[ValueType], where: str, default: Any = REQUIRED) -> ValueType:
    """Return the value of ``key``, which has to be of type ``kind``; a whole number is a float as well.

    Raises:
        InputError: the key is missing and has no default, another type, a number that is not finite.
    """
    if key not in table and default is REQUIRED:
        raise MissingKeyError(f"{where}: key {key!r} is missing, {_KINDS[kind]} wanted{line_of(table)}")
    value = table.get(key, default)
    if kind is float and type(value) is int and in_range(value):
        value = float(value)
    right = isinstance(value, kind) and type(value) in (kind, LinedTable)  # a bool is an int to isinstance
    if not right or (isinstance(value, float) and not in_range(value)):
        raise InputError(f"{where}: {key} = {shown(value)}, {_KINDS[kind]} wanted{line_of(table, key)}")
    return value


def take_positive(table: Mapping[str, Any], key: str, where: str, default: Any = REQUIRED) -> float:
    """Return a number above 0, or raise an InputError."""
    value = take(table, key, float, where, default)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value}, a positive number wanted{line_of(table, key)}")
    return value


def take_from_zero(table: Mapping[str, Any], key: str, where: str, default: Any = REQUIRED) -> float:
    """Return a number >= 0, or raise an InputError."""
    value = take(table, key, float, where, default)
    if value < 0:
        raise InputError(f"{where}: {key} = {value}, a number from 0 up wanted{line_of(table, key)}")
    return value


def take_choice(table: Mapping[str, Any], key: str, choices: Sequence[str], where: str, default: Any = REQUIRED) -> str:
    """Return one of the texts ``choices``, or raise an InputError."""
    value = take(table, key, str, where, default)
    if value not in choices:
        wanted = " or ".join(filter(None, (", ".join(map(repr, choices[:-1])), repr(choices[-1]))))
        raise InputError(f"{where}: {key} = {shown(value)}, {wanted} wanted{line_of(table, key)}")
    return value


def take_numbers(table: Mapping[str, Any], key: str, count: int, where: str, default: Any = REQUIRED) -> list[float]:
    """Return a list of ``count`` finite numbers, or raise an InputError."""
    with located(table, key):
        return numbers(take(table, key, list, where, default), count, f"{where}: {key}")


def numbers(values: Any, count: int, where: str) -> list[float]:
    """Return ``values`` as ``count`` finite floats, or raise an InputError."""
    right = isinstance(values, list) and len(values) == count
    if not right or not all(type(value) in (int, float) and in_range(value) for value in values):
        raise InputError(f"{where} = {shown(values)}, a list of {count} finite numbers wanted")
    return [float(value) for value in values]


def take_duration(table: Mapping[str, Any], where: str) -> Any:
    """Return the key ``duration``: "settled" or a number of time constants >= 0; else raise an InputError."""
    value = table["duration"]
    if value == "settled" or (type(value) in (int, float) and in_range(value) and value >= 0):
        return value
    wanted = "'settled' or a number of time constants >= 0 wanted"
    raise InputError(f"{where}: duration = {shown(value)}, {wanted}{line_of(table, 'duration')}")


def take_tables(table: Mapping[str, Any], key: str, where: str) -> list[dict[str, Any]]:
    """Return the tables [[key]], an empty list if there are none; raise an InputError for anything else."""
    tables = table.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(entry, dict) for entry in tables):
        raise InputError(f"{where}: {key!r} is {shown(tables)}, [[{key}]] tables wanted{line_of(table, key)}")
    return tables
