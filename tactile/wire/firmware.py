"""Firmware for an array description: the sketch, header and CircuitPython file of examples/firmware, configured."""

import re
from collections.abc import Mapping

import numpy as np

from cnnsim.cli.examples import sources
from cnnsim.support import InputError
from tactile.wire.description import Board, Description
from tactile.wire.packets import FIRM

FOLDER = "examples/firmware"
HEADER, SKETCH, PYTHON = "tactile_native.h", "firmware.ino", "circuitpython.py"
RATE = 100
"""[Hz] Frames per second of each array."""
LARGEST = 2**15 - 1
_BLOCK = r"(?<=begin of the configuration\n)(.*?)(?=\S+ end of the configuration)"


def firmware(
    description: Description, name: str, rate: int = RATE, filled: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the files of a firmware by name: NAME.ino, tactile_native.h and code.py.

    Boards with gains send int16 counts, which the host multiplies by the gains; other boards, and those whose gains are
    too small for int16, send float32. Of the files in ``filled``, by name, only the configuration is written anew.

    Raises:
        InputError: the protocol is not ``native``; a filled file without the lines around the configuration.
    """
    if description.wire.name != "native":
        raise InputError(f"{name}: protocol {description.wire.name!r}; native wanted, which the firmware sends")
    shipped = {path.name: path for place, path in sources().items() if place.startswith(FOLDER)}
    configurations = {SKETCH: _cpp(description, rate), PYTHON: _python(description, rate)}
    written = {HEADER: shipped[HEADER].read_text(encoding="utf-8")}
    for file, lines in configurations.items():
        to = "code.py" if file == PYTHON else f"{name}.ino"
        text = (filled or {}).get(to) or shipped[file].read_text(encoding="utf-8")
        parts = re.split(_BLOCK, text, maxsplit=1, flags=re.DOTALL)
        if len(parts) != 3:
            raise InputError(
                f"{to}: no lines 'begin of the configuration' and 'end of the configuration', between which it is "
                "written anew; a file with both wanted, or another --output"
            )
        before, _, after = parts
        written[to] = before + "".join(f"{line}\n" for line in lines) + after
    return written


def _cpp(description: Description, rate: int) -> list[str]:
    whole, shapes = _whole(description), description.options.shapes
    kind = ("int16_t", "int16") if whole else ("float", "float32")
    rows = [
        f"  {{{n}, {shape[0]}, {shape[1]}, 0}},  // {board.array.name}: {_words(board)}"
        for n, (shape, board) in enumerate(zip(shapes, description.boards, strict=True))
    ]
    return [
        f"const uint32_t RATE_HZ = {rate}, BAUDRATE = {description.baudrate};",
        f"const uint32_t FINGERS = {len(shapes)}, MOST_TAXELS = {max(description.options.taxels)};",
        f"typedef {kind[0]} value_t;",
        f"#define SEND tactile_encode_{kind[1]}",
        "tactile_board boards[FINGERS] = {  // number, rows, columns, first sequence number",
        *rows,
        "};",
        f"const float GAINS[FINGERS][3] = {_braces(_gains, description)};  // quantity per count of x, y, z",
        f"const float TOUCH[FINGERS][3] = {_braces(_touch, description)};  // quantity of the test pattern",
    ]


def _braces(part: object, description: Description) -> str:
    assert callable(part)
    return f"{{{', '.join('{' + ', '.join(map(repr, part(board))) + '}' for board in description.boards)}}}"


def _python(description: Description, rate: int) -> list[str]:
    whole = _whole(description)
    rows = []
    for board, shape in zip(description.boards, description.options.shapes, strict=True):
        rows += [f"    # {board.array.name}: {_words(board)}"]
        rows += [f"    ({shape[0]}, {shape[1]}, {_gains(board)}, {_touch(board)}),"]
    return [
        f"RATE_HZ = {rate}",
        'FORMAT = "h"  # counts, int16' if whole else 'FORMAT = "f"  # float32',
        "FINGERS = (  # rows, columns, quantity per count of x, y, z, quantity of the test pattern",
        *rows,
        ")",
    ]


def _whole(description: Description) -> bool:
    """Return whether counts are sent as int16."""
    return all(
        board.gains is not None and max(np.abs(np.divide(_touch(board), _gains(board)))) <= LARGEST
        for board in description.boards
    )


def _words(board: Board) -> str:
    gains, quantity = board.gains, board.array.quantity
    if gains is None:
        return f"the values are the {quantity}"
    return f"the host computes {quantity} = {gains.shear:g} * shear count, {gains.normal:g} * normal count"


def _gains(board: Board) -> tuple[float, ...]:
    """Return the quantity per unit of the device's x, y and z."""
    if board.gains is None:
        return (1.0, 1.0, 1.0)
    return tuple((np.abs(board.turn.T) @ [board.gains.shear, board.gains.shear, board.gains.normal]).tolist())


def _touch(board: Board) -> tuple[float, ...]:
    """Return a firm touch along the device's x, y and z, in the unit of the quantity."""
    quantity = board.array.quantity
    normal = FIRM[quantity] if quantity == "force" else -FIRM[quantity]
    return tuple((board.turn.T @ [0.0, 0.0, normal] + 0.0).tolist())
