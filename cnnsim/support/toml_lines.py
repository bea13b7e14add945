"""Lines of a TOML file: where each key and each table stands, for messages. The standard library's reader tells values.

The text has been read as TOML already, so what is wrong with it need not be found here.
"""

import re
from typing import Any

Path = tuple[str | int, ...]
"""Keys, and numbers in arrays, from the top of the file."""

_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)
_SCALAR = re.compile(r"[^,\]}#\n]+")


class LinedTable(dict[str, Any]):
    """A table with the lines of its keys, the ``line`` on which it begins and, of a file, that of its first [table]."""

    line: int | None = None
    first_table: int | None = None
    lines: dict[str, int]


def without(table: dict[str, Any], key: str) -> dict[str, Any]:
    """Return a table without one of its keys, with the lines that it knows."""
    rest = LinedTable({name: value for name, value in table.items() if name != key})
    rest.lines = {}
    if isinstance(table, LinedTable):
        rest.line, rest.first_table, rest.lines = table.line, table.first_table, table.lines
    return rest


def with_lines(data: dict[str, Any], text: str) -> LinedTable:
    """Return the table that was read from a text, it and all tables inside with their lines."""
    scan = _Scan(text)
    whole = _lined(data, (), scan.found)
    assert isinstance(whole, LinedTable)
    whole.line, whole.first_table = None, scan.first_table
    return whole


def _lined(value: Any, path: Path, found: dict[Path, int]) -> Any:
    if isinstance(value, dict):
        table = LinedTable({key: _lined(item, (*path, key), found) for key, item in value.items()})
        table.lines = {key: found[*path, key] for key in value if (*path, key) in found}
        table.line = found.get(path)
        return table
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return [_lined(item, (*path, number), found) for number, item in enumerate(value)]
    return value


class _Scan:
    """Goes through a text once and notes on which line each key, and each table of an array, begins."""

    def __init__(self, text: str) -> None:
        self.text, self.at, self.line, self.counted = text.replace("\r\n", "\n"), 0, 1, 0
        self.found: dict[Path, int] = {}
        self.first_table: int | None = None
        self.arrays: dict[Path, int] = {}
        table: Path = ()
        while self._skip():
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)

    def _skip(self, pattern: re.Pattern[str] = _SPACE) -> bool:
        """Go over blanks, ends of lines and comments, or another pattern; return whether text is left."""
        match = pattern.match(self.text, self.at)
        self.at = self.at if match is None else match.end()
        return self.at < len(self.text)

    def _here(self) -> int:
        self.line += self.text.count("\n", self.counted, self.at)
        self.counted = self.at
        return self.line

    def _header(self) -> Path:
        line = self._here()
        self.first_table = self.first_table or line
        many = self.text.startswith("[[", self.at)
        self.at += 1 + many
        path: Path = ()
        keys = self._keys()
        for key in keys:
            path = (*path, key)
            self.found.setdefault(path, line)
            if key is not keys[-1] and path in self.arrays:
                path = (*path, self.arrays[path])
        self.at += 1 + many
        if many:
            self.arrays[path] = self.arrays.get(path, -1) + 1
            path = (*path, self.arrays[path])
            self.found[path] = line
        return path

    def _keys(self) -> list[str]:
        """Read a dotted key, up to what follows it."""
        keys: list[str] = []
        while self._skip() and self.text[self.at] not in "=]":
            if self.text[self.at] == ".":
                self.at += 1
            elif (match := _STRING.match(self.text, self.at)) is not None:
                keys.append(match.group()[1:-1])
                self.at = match.end()
            else:
                start = self.at
                self._skip(_BARE)
                keys.append(self.text[start : self.at])
                self.at += self.at == start  # nothing that a reader of TOML lets through comes here
        return keys

    def _pair(self, table: Path) -> None:
        line, path = self._here(), table
        for key in self._keys():
            path = (*path, key)
            self.found.setdefault(path, line)
        self.at += 1
        self._skip()
        self._value(path)

    def _value(self, path: Path) -> None:
        self.found.setdefault(path, self._here())
        opening = self.text[self.at]
        if opening == "[":
            self._inside("]", path)
        elif opening == "{":
            self._inside("}", path)
        elif not _STRING.match(self.text, self.at):
            self._skip(_SCALAR)
        else:
            self._skip(_STRING)

    def _inside(self, closing: str, path: Path) -> None:
        self.at += 1
        number = 0
        while self._skip() and self.text[self.at] != closing:
            if self.text[self.at] == ",":
                self.at += 1
            elif closing == "]":
                self._value((*path, number))
                number += 1
            else:
                self._pair(path)
        self.at += 1
