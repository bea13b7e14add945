"""Values that several tables of a scene file take: positive numbers, a finger's name, paths of keyframes."""

from typing import Any, Literal

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.toml_file import REQUIRED, numbers, take


def positive(table: dict[str, Any], key: str, where: str, default: Any = REQUIRED) -> float:
    """Take a positive number.

    Raises:
        InputError: it is missing, no number, or not positive.
    """
    value = take(table, key, float, where, default)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value}, a positive number wanted")
    return value


def quantity_of(cover: dict[str, Any], where: str) -> Literal["strain", "stress"]:
    """Take what the taxels under a cover measure: strain, unless it says stress.

    Raises:
        InputError: anything else.
    """
    quantity = take(cover, "quantity", str, where, "strain")
    if quantity not in ("strain", "stress"):
        raise InputError(f"{where}: quantity = {quantity!r}, 'strain' or 'stress' wanted")
    return quantity  # type: ignore[return-value]  # one of the two


def one_finger(table: dict[str, Any], names: list[str], where: str) -> int:
    """Take the number of the finger that a table names.

    Raises:
        InputError: no finger of that name.
    """
    name = take(table, "finger", str, where)
    if name not in names:
        raise InputError(f"{where}: finger = {name!r}, one of {', '.join(names)} wanted")
    return names.index(name)


def keyframes(table: dict[str, Any], columns: str, where: str) -> Floats:
    """Take a path: rows of as many numbers as ``columns`` names, the first of which is a growing time.

    Raises:
        InputError: no rows, a row of another length, times that do not grow.
    """
    rows = take(table, "path", list, where)
    if not rows:
        raise InputError(f"{where}: path has no keyframe, at least one [{columns}] wanted")
    count = columns.count(",") + 1
    path = np.array([numbers(row, count, f"{where}: keyframe [{columns}] {n}") for n, row in enumerate(rows, 1)])
    for n, (before, after) in enumerate(zip(path[:-1, 0].tolist(), path[1:, 0].tolist(), strict=True), 2):
        if after <= before:
            raise InputError(f"{where}: keyframe {n} at t_s = {after} after {before}, growing times wanted")
    return path
