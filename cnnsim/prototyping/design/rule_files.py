"""Rules from files: a truth table in TOML, or pairs of pictures from which the windows are read."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.network import Boundary
from cnnsim.prototyping.design.rule import WindowRule, window_text, windows
from cnnsim.support import Flags, Floats, InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.pictures.read import read_picture
from cnnsim.support.toml_file import located, read_toml
from cnnsim.support.values import as_numbers

PicturePair = tuple[Floats, Floats]
"""An input picture and the output it should give, both -1 and +1."""

_CODES = {".": (-1,), "#": (1,), "?": (-1, 1)}


def read_table(path: str | Path) -> WindowRule:
    """Read a truth table: ``black`` and ``white`` list windows as three strings of ``#``, ``.`` and ``?`` (either).

    A fourth string of one character is the initial state. ``default`` is the answer for windows that are in neither
    list: "black", "white", or "either" (the default).

    Raises:
        InputError: no such file, unknown keys, a window of another form, or one that is in both lists.
    """
    data = read_toml(Path(path), "truth table")
    faults = ErrorList(str(path))
    faults.check(data, ("black", "white", "default"))
    table = _table(data, faults)
    faults.raise_all()
    return WindowRule(table, f"the truth table {Path(path).name}")


def _table(data: dict[str, Any], faults: ErrorList) -> NDArray[np.int8]:
    lists: dict[int, list[Any]] = {1: [], -1: []}
    for colour, name in ((1, "black"), (-1, "white")):
        with faults.collecting(), located(data, name):
            item = data.get(name, [])
            if not isinstance(item, list) or not all(isinstance(window, list) for window in item):
                raise InputError(f"{name} holds windows: lists of three strings, one for each row")
            lists[colour] = item
    size = 10 if any(len(window) == 4 for item in lists.values() for window in item) else 9
    rows = windows(size)
    table = np.zeros(1 << size, dtype=np.int8)
    for colour, item in lists.items():
        for window in item:
            with faults.collecting(), located(data, "black" if colour > 0 else "white"):
                match = _matches(rows, window)
                if (table[match] == -colour).any():
                    both = rows[match][table[match] == -colour][0]
                    raise InputError(f"window {window_text(both)} is in both lists, black and white; one wanted")
                table[match] = colour
    default = data.get("default", "either")
    with faults.collecting(), located(data, "default"):
        if default not in ("black", "white", "either"):
            raise InputError(f"default is {shown(default)}; 'black', 'white' or 'either' wanted")
        table[table == 0] = {"black": 1, "white": -1, "either": 0}[default]
    return table


def _matches(rows: NDArray[np.int8], window: list[Any]) -> Flags:
    shape = [len(row) if isinstance(row, str) else -1 for row in window]
    if shape not in ([3, 3, 3], [3, 3, 3, 1]):
        raise InputError(
            f"window {window!r}; three strings of three characters wanted, and perhaps one of one for x(0)"
        )
    characters = "".join(window)
    strange = set(characters) - set(_CODES)
    if strange:
        raise InputError(f"window {window!r} holds {sorted(strange)[0]!r}; '#', '.' and '?' wanted")
    match = np.ones(len(rows), dtype=bool)
    for cell, character in enumerate(characters):
        match &= np.isin(rows[:, cell], _CODES[character])
    return match


def as_pair(pair: tuple[ArrayLike, ArrayLike]) -> PicturePair:
    """Return two pictures as CNN values; booleans are black and white.

    Raises:
        InputError: two sizes, or whole numbers as of grey levels.
    """
    first, second = (as_numbers(name, values) for name, values in zip(("input", "output"), pair, strict=True))
    if first.shape != second.shape or first.ndim != 2:
        raise InputError(f"a pair of pictures of shapes {first.shape} and {second.shape}; one (rows, cols) wanted")
    return first, second


def read_pairs(texts: Sequence[str]) -> list[PicturePair]:
    """Read pairs of pictures given as "input.png=output.png"; both become black and white.

    Raises:
        InputError: another form, a picture that cannot be read, or two of different size.
    """
    pairs = []
    for text in texts:
        first, equals, second = text.partition("=")
        if not equals or not first or not second:
            raise InputError(f"pair {text!r}; INPUT=OUTPUT wanted, two pictures")
        pair = read_picture(first, binary=True), read_picture(second, binary=True)
        if pair[0].shape != pair[1].shape:
            raise InputError(
                f"pair {text!r}: the input is {pair[0].shape}, the output {pair[1].shape}; one size wanted"
            )
        pairs.append(pair)
    return pairs


def rule_of_pairs(pairs: Sequence[PicturePair], boundary: Boundary) -> WindowRule:
    """Return what pairs of pictures say: the answer of every window that occurs; all others are left open.

    Raises:
        InputError: one window is black in one place and white in another; the message names both places.
    """
    table = np.zeros(512, dtype=np.int8)
    seen: dict[int, str] = {}
    blank = WindowRule(np.ones(512, dtype=np.int8))
    for number, (picture, wanted) in enumerate(map(as_pair, pairs), start=1):
        codes = blank.codes(picture, boundary, None)
        for (row, col), code in np.ndenumerate(codes):
            here = f"pair {number}, cell {row},{col}"
            colour = 1 if wanted[row, col] > 0 else -1
            if table[code] == -colour:
                names = {1: "black", -1: "white"}
                raise InputError(
                    f"window {window_text(blank.rows[code])} becomes {names[-colour]} in {seen[int(code)]} and "
                    f"{names[colour]} in {here}; one colour for each window wanted"
                )
            table[code] = colour
            seen.setdefault(int(code), here)
    return WindowRule(table, f"{len(pairs)} pair{'s' * (len(pairs) != 1)} of pictures")
