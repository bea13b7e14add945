"""Named columns as arrays of records: a compiled loop takes one parameter and reads its fields by name."""

from typing import Any

import numpy as np

from cnnsim.network import Tap
from cnnsim.support import Array


def records(columns: Any) -> Array:
    """Return a NamedTuple of columns of one length as an array of records, whose fields have the columns' names."""
    fields = columns._asdict()
    table = np.empty(len(columns[0]), np.dtype([(name, column.dtype) for name, column in fields.items()], align=True))
    for name, column in fields.items():
        table[name] = column
    return table


def tap_records(taps: tuple[Tap, ...], dtype: np.dtype[Any]) -> Array:
    """Return taps as records (k, l, weight)."""
    return np.array([tuple(tap) for tap in taps], tap_type(dtype))


def tap_type(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """Return the type of a tap's record."""
    return np.dtype([("k", np.int64), ("l", np.int64), ("weight", dtype)], align=True)
