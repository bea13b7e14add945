"""Line numbers of the keys and tables of a TOML text, for error messages. The values are read by `tomllib`."""

import re
from bisect import bisect_left
from typing import Any

Path = tuple[str | int, ...]
"""Keys, and numbers in arrays, from the top of the file."""

_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_STRING = re.compile(r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)
_BARE, _SCALAR = re.compile(r"[A-Za-z0-9_-]+"), re.compile(r"[^,\]}#\n]+")
DEPTH = 32
"""Parts of a dotted key, and brackets within each other, at most: `tomllib` takes the square of them in memory."""
_TEXTS = re.compile(
    r'''#[^\n]*|"""(?:\\.|[^\\])*?(?:"{3,5}|\Z)|\'{3}.*?(?:\'{3,5}|\Z)'''
    r"""|"(?:\\.|[^"\\\n])*+(?:"|.*)|'[^'\n]*+(?:'|.*)""",
    re.DOTALL,
)
"""Comments and strings; one without an end takes the rest of the text, which is no TOML."""
_LONG_KEY = re.compile(rf"(?<![\w-])(?:(?:[\w-]++|'')[ \t]*+\.[ \t]*+){{{DEPTH}}}")


class LinedTable(dict[str, Any]):
    """A table with the ``lines`` of its keys, its own first ``line`` and, of a file, that of the first [table]."""

    line: int | None = None
    first_table: int | None = None

    def __init__(self, table: dict[str, Any], lines: dict[str, int]) -> None:
        super().__init__(table)
        self.lines = lines


def without(table: dict[str, Any], key: str) -> dict[str, Any]:
    """Return a table without one of its keys; the line numbers are kept."""
    rest = LinedTable({name: value for name, value in table.items() if name != key}, getattr(table, "lines", {}))
    rest.line, rest.first_table = getattr(table, "line", None), getattr(table, "first_table", None)
    return rest


def is_too_deep(text: str) -> bool:
    """Return whether a dotted key has more than `DEPTH` parts, or brackets are nested deeper."""
    bare = _TEXTS.sub("''", text)
    deepest = depth = 0
    for bracket in re.sub(r"[^][{}]+", "", bare):
        depth = max(0, depth + (1 if bracket in "[{" else -1))
        deepest = max(deepest, depth)
    return deepest > DEPTH or _LONG_KEY.search(bare) is not None


def with_lines(data: dict[str, Any], text: str) -> LinedTable:
    """Return the table that was read from a text; it and all tables in it have their line numbers."""
    scan = _Scan(text)
    whole = _lined(data, (), scan.found)
    assert isinstance(whole, LinedTable)
    whole.first_table = scan.first_table
    return whole


def _lined(value: Any, path: Path, found: dict[Path, int]) -> Any:
    if isinstance(value, dict):
        items = {key: _lined(item, (*path, key), found) for key, item in value.items()}
        table = LinedTable(items, {key: found[*path, key] for key in value if (*path, key) in found})
        table.line = found.get(path)
        return table
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return [_lined(item, (*path, number), found) for number, item in enumerate(value)]
    return value


class _Scan:
    """The line on which each key and each table of an array begins, by its path; the text is valid TOML."""

    def __init__(self, text: str) -> None:
        self.text, self.at, self.found = text.replace("\r\n", "\n"), 0, dict[Path, int]()
        self.ends = [match.start() for match in re.finditer("\n", self.text)]
        self.first_table: int | None = None
        table: Path = ()
        last: dict[Path, int] = {}
        while (line := self._line()) and self.at < len(self.text):
            if not self._take("["):
                self._pair(table)
                continue
            self.first_table = self.first_table or line
            many, table = self._take("["), ()
            keys = self._keys()
            for number, key in enumerate(keys, 1):
                table = (*table, key)
                self.found.setdefault(table, line)
                if table in last and number < len(keys):
                    table = (*table, last[table])
            if many:
                last[table] = last.get(table, -1) + 1
                table = (*table, last[table])
                self.found[table] = line
            self.at += 1 + bool(many)

    def _line(self) -> int:
        """Skip blanks and comments; return the number of the line."""
        self.at = _SPACE.match(self.text, self.at).end()  # type: ignore[union-attr]  # it matches nothing as well
        return bisect_left(self.ends, self.at) + 1

    def _take(self, wanted: str | re.Pattern[str]) -> str:
        """Return the text that comes next if it is the one wanted, and go on after it; else an empty text."""
        self._line()
        if isinstance(wanted, str):
            taken = wanted if self.text.startswith(wanted, self.at) else ""
        else:
            taken = match.group() if (match := wanted.match(self.text, self.at)) else ""
        self.at += len(taken)
        return taken

    def _keys(self) -> list[str]:
        keys = [self._take(_STRING)[1:-1] or self._take(_BARE)]
        return keys + self._keys() if self._take(".") else keys

    def _pair(self, path: Path) -> None:
        line = self._line()
        for key in self._keys():
            path = (*path, key)
            self.found.setdefault(path, line)
        self._take("=")
        self._value(path)

    def _value(self, path: Path) -> None:
        self.found.setdefault(path, self._line())
        if self._take("["):
            number = 0
            while not self._take("]"):
                self._value((*path, number))
                self._take(",")
                number += 1
        elif self._take("{"):
            while not self._take("}"):
                self._pair(path)
                self._take(",")
        elif not self._take(_STRING):
            self._take(_SCALAR)
