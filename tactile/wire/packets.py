"""Packets of an emulated device: the frames of a scene or recording in a wire format, with their times."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from cnnsim.support import InputError
from tactile.core.array_table import array_table, toml_text
from tactile.core.frame import Frame
from tactile.core.source import Source
from tactile.wire.arrange import back
from tactile.wire.base import Encoder
from tactile.wire.description import Description
from tactile.wire.description_file import parse_description
from tactile.wire.reading import Taxels
from tactile.wire.registry import find_format

FIRM = {"strain": 0.01, "stress": 2e4, "force": 1.0}
"""Reading of a firm touch for every quantity [1, Pa, N]."""
KEPT = 50_000
"""Number of frames up to which all are computed before the first is sent."""

TimedPacket = tuple[float, bytes]
"""Time since the start of the device [s], and the bytes sent then."""


def emulated_description(protocol: str, source: Source) -> Description:
    """Return a description of a device that could have measured the frames of a source.

    Raises:
        InputError: the arrays of the source do not fit the protocol.
    """
    wire = find_format(protocol)
    if wire.single and len(source.arrays) > 1:
        raise InputError(f"protocol {protocol!r} carries one array, {source.title!r} has {len(source.arrays)}")
    fingers = []
    for array in source.arrays:
        finger = array_table(array, "mm")
        if wire.pushes and array.quantity != "force":
            finger["axes"] = ["x", "y", "-z"]
        if wire.strong is not None:
            finger["gains"] = [FIRM[array.quantity] / wire.strong] * 2
        fingers.append(finger)
    top: dict[str, Any] = {"title": source.title, "protocol": protocol}
    if source.modulus is not None:
        top["youngs_modulus_mpa"] = source.modulus * 1e-6
    return parse_description(toml_text(top, fingers), f"emulated {protocol}")


def check_form(protocol: str, source: Source) -> None:
    """Refuse a source whose arrays do not have the fixed form of this protocol.

    Raises:
        InputError: names both shapes.
    """
    wanted = [(finger["rows"], finger["cols"]) for finger in find_format(protocol).fingers]
    found = [array.shape for array in source.arrays]
    if wanted and found != wanted:
        raise InputError(
            f"{source.title!r} has arrays of {_shapes(found)}; protocol {protocol!r} is always read as"
            f" {_shapes(wanted)}: such a scene, or --write-array FILE and `tactile live -a FILE` wanted"
        )


def _shapes(shapes: Iterable[tuple[int, int]]) -> str:
    return " and ".join(f"{rows} x {cols}" for rows, cols in shapes)


def packets(
    description: Description, source: Source, loop: bool = False, device: Encoder | None = None
) -> Iterator[TimedPacket]:
    """Return the packets of the described device for the frames of a source; ``loop`` repeats them.

    ``device``: the encoder, if the caller needs it too. Slow work is done before this returns, so that the first
    packets are in time.

    Raises:
        InputError: the arrays of the source differ from those of the description.
    """
    if [array.shape for array in source.arrays] != [array.shape for array in description.arrays]:
        found, wanted = (_shapes(array.shape for array in one.arrays) for one in (source, description))
        raise InputError(f"{source.title!r} has arrays of {found}; the array description has {wanted}")
    few = source.frames is not None and source.frames <= KEPT
    readings = _Readings(description, source)
    encoder = device or description.wire.encoder(description.options)
    return _packets(encoder, list(readings) if few else readings, loop)


class _Readings:
    """Readings of all boards at every time of a source; iterable repeatedly."""

    def __init__(self, description: Description, source: Source) -> None:
        self._boards, self._source, self._blanks = description.boards, source, description.wire.blanks

    def __iter__(self) -> Iterator[tuple[float, list[Taxels]]]:
        for t, frames in instants(self._source, len(self._boards)):
            boards = [back(frame, board) for frame, board in zip(frames, self._boards, strict=True)]
            yield t, boards if self._blanks else [np.nan_to_num(board) for board in boards]


def _packets(encoder: Encoder, readings: Iterable[tuple[float, list[Taxels]]], loop: bool) -> Iterator[TimedPacket]:
    count, begin, preamble = 0, 0.0, encoder.preamble()
    while True:
        last = step = 0.0
        for t, boards in readings:
            yield begin + t, preamble + encoder.encode(boards, count, begin + t)
            count, preamble, step, last = count + 1, b"", t - last, t
        if not loop:
            return
        begin += last + step


def instants(frames: Iterable[Frame], fingers: int) -> Iterator[tuple[float, list[Frame]]]:
    """Yield one frame of every finger, as soon as each has a new one, with the time of the last one [s]."""
    newest: dict[int, Frame] = {}
    for frame in frames:
        newest[frame.finger] = frame
        if len(newest) == fingers:
            yield frame.t, [newest[finger] for finger in range(fingers)]
            newest = {}
