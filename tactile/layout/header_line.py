"""Columns of text lines by the names in a board's header line, as a layout names those of a recording."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cnnsim.support import Integers
from tactile.layout.select import readings
from tactile.layout.table import Table

if TYPE_CHECKING:
    from tactile.layout.layout import Layout


class LineColumns(NamedTuple):
    """Number of columns; those of the ``taxels`` of all boards, of ``sequence`` and ``time``, and its unit [s]."""

    width: int
    taxels: Integers
    sequence: int | None
    time: int | None
    unit: float


def line_columns(names: Sequence[str], layout: "Layout") -> LineColumns:
    """Return where a layout finds its columns in lines with these ``names``.

    Each column of a made-up table holds its own number, so what the layout reads from it are the columns it wants.

    Raises:
        InputError: as for a recording with these columns.
    """
    from tactile.layout.layout import UNITS  # it imports the array descriptions, which import the protocols

    table = Table(Path("the header line"), {name: np.array([names.index(name)]) for name in names})
    taxels = np.concatenate([readings(table, finger)[0].ravel() for finger in layout.fingers]).astype(np.intp)
    named = (("sequence", layout.sequence), ("device_time", layout.device_time), ("time", layout.time))
    sequence, device, stamp = (None if name is None else int(table.numbers(name, what)[0]) for what, name in named)
    unit = layout.unit if device is None else layout.device_unit
    return LineColumns(len(names), taxels, sequence, stamp if device is None else device, UNITS[unit] * 1e-9)
