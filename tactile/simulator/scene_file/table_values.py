"""Values that several tables of a scene file take: words, a finger's name, friction, paths of keyframes."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.error_list import read_all
from cnnsim.support.toml_file import line_of, located, numbers, take, take_from_zero
from tactile.simulator.contacts.moving_load import MovingLoad

KEYFRAME = "t_s, x_mm, y_mm, Q_N, R_N, F_N"
"""Columns of a load's path."""


def quantity_of(cover: dict[str, Any], where: str) -> Literal["strain", "stress"]:
    """Take what the taxels under a cover measure: strain, unless it says stress.

    Raises:
        InputError: anything else.
    """
    quantity = take(cover, "quantity", str, where, "strain")
    if quantity not in ("strain", "stress"):
        raise InputError(f"{where}: quantity = {quantity!r}, 'strain' or 'stress' wanted{line_of(cover, 'quantity')}")
    return quantity  # type: ignore[return-value]  # one of the two


def one_finger(table: dict[str, Any], names: list[str], where: str) -> int:
    """Take the number of the finger that a table names.

    Raises:
        InputError: no finger of that name.
    """
    name = take(table, "finger", str, where)
    if name not in names:
        raise InputError(f"{where}: finger = {name!r}, one of {', '.join(names)} wanted{line_of(table, 'finger')}")
    return names.index(name)


def keyframes(table: dict[str, Any], columns: str, where: str) -> Floats:
    """Take a path: rows of as many numbers as ``columns`` names, the first of which is a growing time.

    Raises:
        InputError: no rows, a row of another length, times that do not grow.
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
    """Take a point load: its finger, and the path on which it goes.

    Raises:
        InputError: as `one_finger` and `keyframes`.
    """
    finger, path = read_all(where, lambda: one_finger(table, names, where), lambda: keyframes(table, KEYFRAME, where))
    return MovingLoad(finger, path * (1, 1e-3, 1e-3, 1, 1, 1))


def chosen(table: dict[str, Any], key: str, choices: Sequence[str], where: str) -> str:
    """Take one of some words, the first of them where the table has none.

    Raises:
        InputError: something else.
    """
    word = take(table, key, str, where, choices[0])
    if word not in choices:
        wanted = ", ".join(map(repr, choices[:-1])) + f" or {choices[-1]!r}"
        raise InputError(f"{where}: {key} = {word!r}, {wanted} wanted{line_of(table, key)}")
    return word


def friction_of(table: dict[str, Any], where: str) -> float | None:
    """Take the coefficient of friction, None where the table has none.

    Raises:
        InputError: no number from 0 up.
    """
    return take_from_zero(table, "friction", where) if "friction" in table else None


def take_seed(table: dict[str, Any], where: str) -> int:
    """Take the seed of what is random, 0 where the table has none.

    Raises:
        InputError: no whole number from 0 up.
    """
    seed = take(table, "seed", int, where, 0)
    if seed < 0:
        raise InputError(f"{where}: seed = {seed}, a whole number from 0 up wanted{line_of(table, 'seed')}")
    return seed
