"""Readers of values in several tables of a scene file: finger names, friction, seeds, paths of keyframes."""

from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.error_list import read_all
from cnnsim.support.toml_file import line_of, located, numbers, take, take_from_zero
from tactile.simulator.contacts.moving_load import MovingLoad

KEYFRAME = "t_s, x_mm, y_mm, Q_N, R_N, F_N"
"""Columns of a load's path."""


def one_finger(table: dict[str, Any], names: list[str], where: str) -> int:
    """Return the number of the finger that a table names.

    Raises:
        InputError: no finger of that name.
    """
    name = take(table, "finger", str, where)
    if name not in names:
        raise InputError(f"{where}: finger = {name!r}, one of {', '.join(names)} wanted{line_of(table, 'finger')}")
    return names.index(name)


def keyframes(table: dict[str, Any], columns: str, where: str) -> Floats:
    """Return a path: rows of the numbers that ``columns`` names, the first of them an increasing time.

    Raises:
        InputError: no rows, a row of another length, times that do not increase.
    """
    rows = take(table, "path", list, where)
    with located(table, "path"):
        if not rows:
            raise InputError(f"{where}: path has no keyframe, at least one [{columns}] wanted")
        count = columns.count(",") + 1
        path = np.array([numbers(row, count, f"{where}: keyframe [{columns}] {n}") for n, row in enumerate(rows, 1)])
        for n, (before, after) in enumerate(zip(path[:-1, 0].tolist(), path[1:, 0].tolist(), strict=True), 2):
            if after <= before:
                raise InputError(f"{where}: keyframe {n} at t_s = {after} after {before}, growing times wanted")
    return path


def read_load(table: dict[str, Any], names: list[str], where: str) -> MovingLoad:
    """Return a point load that moves along a path.

    Raises:
        InputError: as `one_finger` and `keyframes`.
    """
    finger, path = read_all(where, lambda: one_finger(table, names, where), lambda: keyframes(table, KEYFRAME, where))
    return MovingLoad(finger, path * (1, 1e-3, 1e-3, 1, 1, 1))


def friction_of(table: dict[str, Any], where: str) -> float | None:
    """Return the coefficient of friction, None where the table has none.

    Raises:
        InputError: no number from 0 up.
    """
    return take_from_zero(table, "friction", where) if "friction" in table else None


def take_seed(table: dict[str, Any], where: str) -> int:
    """Return the seed of random numbers, 0 where the table has none.

    Raises:
        InputError: no whole number from 0 up.
    """
    seed = take(table, "seed", int, where, 0)
    if seed < 0:
        raise InputError(f"{where}: seed = {seed}, a whole number from 0 up wanted{line_of(table, 'seed')}")
    return seed
