"""The global wire: one value of a whole black-and-white plane, any, all or the count of its black cells."""

from typing import Literal, get_args

import numpy as np

from cnnsim.support import Integers
from cnnsim.support.errors import not_known

Wire = Literal["any", "all", "count"]
Register = int | Integers


def read_wire(wire: Wire, black: Register, cells: int) -> Register:
    """Return the wire's value: 1 or 0 for "any" and "all" black, the number of black cells for "count".

    ``cells`` is the size of one grid; for n grids ``black`` and the value are (n,) numbers.
    """
    if wire == "count":
        return black
    value = black > 0 if wire == "any" else black == cells
    return value.astype(np.int64) if isinstance(value, np.ndarray) else int(value)


def check_wire(name: str) -> Wire:
    """Return ``name`` as a wire.

    Raises:
        InputError: there is no such wire.
    """
    if name not in get_args(Wire):
        raise not_known("global wire", name, get_args(Wire))
    return name  # type: ignore[return-value]  # just checked
