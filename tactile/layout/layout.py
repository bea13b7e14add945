"""Layout of foreign tables: which columns are the readings of which taxels, and which are times.

A layout is an array file (CONNECT.md) with a table [layout], and with ``columns`` in each [[finger]]; ``protocol`` may
be missing. ``layout = "FILE"`` in an array file names another file that has them.

[layout]
time = "stamp"            # column of times, by name or by number from 0; or:
rate_hz = 100             # samples a second, where there is no time
time_unit = "ms"          # s (default), ms, us or ns
device_time = "tus"       # optional: column of the device clock, in device_unit
device_unit = "us"
sequence = "frame"        # optional: column of sequence numbers
take = "episode"          # optional: column whose value changes with each take, or pattern of the groups of takes
files = "*.csv"           # optional: files of a folder that are read
skip_lines = 0            # of a text file, before its header
skip_rows = 0             # samples at the beginning that are not used
separator = ";"           # of a text file; found by itself
decimal = ","             # the same
topic = "/hand"           # of MCAP files and ROS bags
tared = false             # true: the offsets are already subtracted
[[finger]]
columns = "S{taxel}_{axis}"   # see `tactile.layout.select`
order = "taxel"           # of columns without these names: "taxel" (x0, y0, z0, x1, ...) or "axis" (x0, x1, ...)
dims = ["time", "taxel", "axis"]   # of one array: also "row", "col" and "take"
where = {sensor = "left"} # only the rows in which these columns have these values
axes = ["x", "y", "-z"]   # as in an array file; ["z"] or ["-z"]: the normal alone
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.limits import RATE, check_most
from cnnsim.support.toml_file import (
    line_of,
    located,
    parse_toml,
    read_toml,
    take,
    take_choice,
    take_positive,
    take_tables,
)
from tactile.core.frame import TaxelArray
from tactile.wire.description import Board
from tactile.wire.description_file import FINGER_KEYS, MODULUS, NEEDED, TOP_KEYS, take_board

UNITS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
"""Unit of time -> ns."""
KEYS = (
    "time", "rate_hz", "time_unit", "device_time", "device_unit", "sequence", "take", "files", "skip_lines",
    "skip_rows", "separator", "decimal", "topic", "tared",
)  # fmt: skip
DIMS = ("time", "take", "row", "col", "taxel", "axis")
ORDERS = ("taxel", "axis")

Column = str | int


@dataclass(frozen=True)
class FingerLayout:
    """Readings of one finger: its ``board``, ``columns``, their ``order`` or ``dims``, and the rows it has."""

    board: Board
    columns: tuple[Column, ...]
    order: str = "taxel"
    dims: tuple[str, ...] = ()
    where: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Layout:
    """Contents of a layout; None or an empty text for what it does not have. ``text`` is the file."""

    fingers: tuple[FingerLayout, ...]
    title: str = ""
    modulus: float | None = None
    time: Column | None = None
    rate: float | None = None
    unit: str = "s"
    device_time: Column | None = None
    device_unit: str = "us"
    sequence: Column | None = None
    takes: str = ""
    files: str = ""
    skip_lines: int = 0
    skip_rows: int = 0
    separator: str = ""
    decimal: str = ""
    topic: str = ""
    tared: bool = False
    text: str = field(default="", repr=False)

    @property
    def arrays(self) -> tuple[TaxelArray, ...]:
        """Arrays of the fingers."""
        return tuple(one.board.array for one in self.fingers)


def read_layout(path: Path) -> Layout:
    """Read a layout.

    Raises:
        InputError: no such file, no TOML, no [layout] in it, an unknown or missing key, a wrong value.
    """
    table = read_toml(path, "layout")
    other = table.get("layout")
    if isinstance(other, str):
        if (path.parent / other).resolve() == path.resolve():
            raise InputError(f"{path}: layout = {other!r} is this file; a table [layout] or another file wanted")
        return read_layout(path.parent / other)
    return parse_layout(path.read_text(encoding="utf-8-sig"), str(path))


def parse_layout(text: str, where: str) -> Layout:
    """Return the layout in a text; ``where`` names it in messages.

    Raises:
        InputError: as `read_layout`.
    """
    table = parse_toml(text, where)
    if not isinstance(table.get("layout"), dict):
        raise InputError(f"{where}: no table [layout], which is wanted; `tactile layout FILE` writes one for a file")
    faults = ErrorList(where)
    faults.check(table, TOP_KEYS, "", ("finger",))
    faults.check(table["layout"], KEYS, "[layout]")
    fingers = []
    with faults.collecting():
        for number, finger in enumerate(take_tables(table, "finger", where), 1):
            faults.check(finger, FINGER_KEYS, f"finger {number}", (*NEEDED, "columns"))
            with faults.collecting():
                fingers.append(_finger(finger, f"{where}: finger {number}"))
    faults.raise_all()
    names = [one.board.array.name for one in fingers]
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    title = take(table, "title", str, where, "")
    modulus = take_positive(table, MODULUS, where) * 1e6 if MODULUS in table else None
    return Layout(tuple(fingers), title, modulus, **_top(table["layout"], f"{where}: [layout]"), text=text)


def _top(table: dict[str, Any], where: str) -> dict[str, Any]:
    rate = take_positive(table, "rate_hz", where) if "rate_hz" in table else None
    if rate is not None:
        check_most(rate, RATE, f"{where}: rate_hz")
    if rate is None and "time" not in table:
        raise InputError(f"{where}: neither time nor rate_hz; a column of times or a rate wanted{line_of(table)}")
    skips = {name: take(table, name, int, where, 0) for name in ("skip_lines", "skip_rows")}
    for name, count in skips.items():
        if count < 0:
            raise InputError(f"{where}: {name} = {count}, 0 or more wanted{line_of(table, name)}")
    texts = {name: take(table, name, str, where, "") for name in ("files", "separator", "decimal", "topic")}
    if len(texts["separator"]) > 1 or texts["decimal"] not in ("", ".", ","):
        raise InputError(f"{where}: separator {texts['separator']!r}, decimal {texts['decimal']!r}; one sign each, a"
                         " point or a comma as decimal sign, wanted")  # fmt: skip
    return {
        "time": _column(table, "time", where), "rate": rate,
        "unit": take_choice(table, "time_unit", tuple(UNITS), where, "s"),
        "device_time": _column(table, "device_time", where),
        "device_unit": take_choice(table, "device_unit", tuple(UNITS), where, "us"),
        "sequence": _column(table, "sequence", where), "takes": take(table, "take", str, where, ""),
        "tared": take(table, "tared", bool, where, False), **texts, **skips,
    }  # fmt: skip


def _column(table: dict[str, Any], key: str, where: str) -> Column | None:
    value = table.get(key)
    if value is not None and (isinstance(value, bool) or not isinstance(value, str | int)):
        raise InputError(f"{where}: {key} = {value!r}, the name or number of a column wanted{line_of(table, key)}")
    return value


def _finger(table: dict[str, Any], where: str) -> FingerLayout:
    board = take_board(table, where)
    found = table.get("columns")
    columns: list[Any] = found if isinstance(found, list) else [found]
    if not columns or not all(isinstance(one, str | int) and not isinstance(one, bool) for one in columns):
        wanted = "names, patterns or numbers of columns wanted"
        raise InputError(f"{where}: columns = {found!r}, {wanted}{line_of(table, 'columns')}")
    dims = take(table, "dims", list, where, [])
    with located(table, "dims"):
        if dims and ("time" not in dims or len(set(dims)) < len(dims) or not set(dims) <= set(DIMS)):
            raise InputError(f'{where}: dims = {dims!r}, "time" and others of {", ".join(DIMS)}, each once, wanted')
    order = take_choice(table, "order", ORDERS, where, "taxel")
    rows = take(table, "where", dict, where, {})
    return FingerLayout(board, tuple(columns), order, tuple(dims), rows)
