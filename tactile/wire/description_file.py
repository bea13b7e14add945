"""Array description files (TOML): boards, wire format, gains and thresholds of a device.

title = "gripper"
protocol = "reskin"             # one of tactile.wire.registry.NAMES; csv if there is a [layout] of foreign tables
baudrate = 115200               # optional
youngs_modulus_mpa = 0.4        # of the cover; required for strain
[options]                       # of the protocol; optional
[[finger]]                      # one per board, in the order of the wire
name = "thumb"
rows = 3
cols = 3
pitch_mm = 7.0
depth_mm = 2.0
quantity = "strain"             # of the readings after the gains: strain, stress or force
axes = ["x", "y", "-z"]         # device axes of shear_x, shear_y and normal; ["z"] or ["-z"]: the normal alone
gains = [1e-5, 2e-5]            # shear, normal: eq. (15); quantity per unit of the wire
cells = [[-1, 1, -1], [4, 0, 2], [-1, 3, -1]]   # chip number of each cell, -1 for none
[thresholds]                    # defaults of the command line; each is optional
dead_band = 1e-3                # least shear that gives a direction [unit of the quantity], as --dead-band
hysteresis = 5e-4               # as --hysteresis
contact_level = 1e-3            # as --contact-level
sigmas = [4, 6, 3]              # as --sigmas
sign_code = false               # as --sign-code
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError, Integers, naming
from cnnsim.support.error_list import ErrorList, read_all
from cnnsim.support.limits import TEXT, check_file, reason
from cnnsim.support.toml_file import (
    check_keys,
    line_of,
    located,
    parse_toml,
    take,
    take_numbers,
    take_positive,
    take_tables,
)
from tactile.calibration.gains import Gains
from tactile.core.array_table import take_array, take_count, toml_text
from tactile.core.file_kinds import refuse_other_kind
from tactile.core.frame import TaxelArray
from tactile.thresholds.choices import take_choices
from tactile.wire.base import Options
from tactile.wire.description import Board, Description
from tactile.wire.registry import Format, find_format

MODULUS = "youngs_modulus_mpa"
TOP_KEYS = ("title", "protocol", "baudrate", MODULUS, "options", "thresholds", "layout", "finger")
"""Keys of the file; ``layout`` is that of `tactile.layout.layout`, for tables of other programs."""
FINGER_KEYS = (
    "name", "rows", "cols", "pitch_mm", "depth_mm", "thickness_mm", "origin_mm", "quantity", "axes", "gains", "cells",
    "columns", "order", "dims", "where",
)  # fmt: skip

NORMAL_ALONE = {"z": 1.0, "+z": 1.0, "-z": -1.0}
"""Axis of boards that measure the normal alone -> its sign."""
NEEDED = ("name", "rows", "cols", "pitch_mm", "depth_mm", "quantity")
"""Required keys of a [[finger]]."""


def read_description(path: Path) -> Description:
    """Read an array description.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a wrong value.
    """
    try:
        check_file(path, "file that describes an array", TEXT)
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise InputError(f"no array description {path}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as an array description: {reason(error)}") from error
    return parse_description(text, str(path))


def parse_description(text: str, where: str) -> Description:
    """Return the description in a text; ``where`` names it in messages.

    Raises:
        InputError: as `read_description`.
    """
    table = parse_toml(text, where)
    refuse_other_kind(table, where, "array description")
    faults = ErrorList(where)
    faults.check(table, TOP_KEYS, "", ("finger",) if "layout" in table else ("protocol", "finger"))
    boards = []
    with faults.collecting():
        for number, finger in enumerate(take_tables(table, "finger", where), 1):
            faults.check(finger, FINGER_KEYS, f"finger {number}", NEEDED)
            with faults.collecting():
                boards.append(take_board(finger, f"{where}: finger {number}"))
    thresholds = take_choices(table.get("thresholds", {}), faults, "[thresholds]")
    with faults.collecting():
        wire, title, extra, baudrate, modulus = read_all(
            where,
            lambda: _format(table, where),
            lambda: take(table, "title", str, where, ""),
            lambda: take(table, "options", dict, where, {}),
            lambda: take_count(table, "baudrate", where) if "baudrate" in table else 0,
            lambda: take_positive(table, MODULUS, where) * 1e6 if MODULUS in table else None,
        )
    faults.raise_all()
    check_keys(extra, wire.keys, f"{where}: [options] of {wire.name}")
    names = [board.array.name for board in boards]
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    quantities = sorted({board.array.quantity for board in boards})
    if len(quantities) > 1 and (thresholds.dead_band, thresholds.contact_level) != (None, None):
        raise InputError(
            f"{where}: [thresholds]: levels for fingers of {' and '.join(quantities)}; fingers of one quantity,"
            f" or sigmas alone wanted, because levels have one unit{line_of(table['thresholds'])}"
        )
    axes = {board.turn.shape[1] for board in boards}
    if len(axes) > 1 or (axes == {1} and not wire.normal_alone):
        raise InputError(
            f"{where}: axes = ['z'] of protocol {wire.name!r}: the normal alone, which all boards of csv may send"
        )
    layout = None
    if wire.name == "csv" and isinstance(table.get("layout"), dict):
        from tactile.layout.layout import parse_layout  # it imports this module

        layout = parse_layout(text, where)
    options = Options(tuple(_wire_shape(board) for board in boards), extra, axes.pop(), layout)
    wire.decoder(options)  # reports wrong options now
    return Description(
        title or wire.summary, wire, baudrate or wire.baudrate, modulus, options, tuple(boards), text, thresholds
    )


def _format(table: dict[str, Any], where: str) -> Format:
    name = take(table, "protocol", str, where, *(["csv"] if "layout" in table else []))
    with located(table, "protocol"):
        return find_format(name)


def default_description(protocol: str) -> Description:
    """Return the description of a device that has only one form.

    Raises:
        InputError: the protocol has more than one form.
    """
    wire = find_format(protocol)
    if not wire.fingers:
        raise InputError(f"protocol {protocol!r} does not say how the taxels lie: --array FILE wanted (CONNECT.md)")
    return parse_description(toml_text({"protocol": protocol}, wire.fingers), protocol)


def take_board(table: dict[str, Any], where: str) -> Board:
    """Return the board of a [[finger]].

    Raises:
        InputError: a missing key or a wrong value.
    """
    array, turn, gains, cells = read_all(
        where,
        lambda: take_array(table, "mm", where),
        lambda: _turn(table, where),
        lambda: _gains(table, where) if "gains" in table else None,
        lambda: take(table, "cells", list, where, []),
    )
    if turn.shape[1] == 1:
        with located(table, "quantity"), naming(where):
            array = replace(array, shear=False)
    with located(table, "cells"):
        return Board(array, turn, gains, _cells(cells, array, where) if "cells" in table else _whole(array))


def _gains(table: dict[str, Any], where: str) -> Gains:
    shear, normal = take_numbers(table, "gains", 2, where)
    with located(table, "gains"), naming(where):
        return Gains(shear, normal)


def _turn(table: dict[str, Any], where: str) -> Floats:
    axes, turn = take(table, "axes", list, where, ["x", "y", "z"]), np.zeros((3, 3))
    if len(axes) == 1 and axes[0] in NORMAL_ALONE:
        return np.array([[0.0], [0.0], [NORMAL_ALONE[axes[0]]]])
    for row, axis in enumerate(axes):
        if not isinstance(axis, str) or axis.lstrip("+-") not in ("x", "y", "z") or len(axis) > 2 or row > 2:
            break
        turn[row, "xyz".index(axis[-1])] = -1.0 if axis[0] == "-" else 1.0
    if abs(np.linalg.det(turn)) != 1.0:
        wanted = "each of x, y, z once wanted, such as ['x', '-y', '-z'], or ['z'] for the normal alone"
        raise InputError(f"{where}: axes = {axes!r}, {wanted}{line_of(table, 'axes')}")
    return turn


def _whole(array: TaxelArray) -> Integers:
    return np.arange(array.rows * array.cols).reshape(array.shape)


def _cells(cells: list[Any], array: TaxelArray, where: str) -> Integers:
    try:
        grid = np.array(cells, dtype=np.int64)
    except (TypeError, ValueError, OverflowError):
        grid = np.empty(0, np.int64)
    used = np.sort(grid[grid >= 0])
    if grid.shape != array.shape or not used.size or not np.array_equal(used, np.arange(used.size)):
        raise InputError(f"{where}: cells = {cells!r}, {array.rows} x {array.cols} chip numbers 0, 1, ... or -1 wanted")
    return grid


def _wire_shape(board: Board) -> tuple[int, int]:
    whole = board.chips == board.array.rows * board.array.cols
    return board.array.shape if whole else (1, board.chips)
