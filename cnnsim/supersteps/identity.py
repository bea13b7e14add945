"""Identity of a run: a checksum of its values and of the contents of its planes."""

import zlib
from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from cnnsim.planning.plan import Plan

ROWS = 1024
"""Rows of a plane that are read at a time."""


def run_identity(plan: Plan, planes: dict[str, Any], backend: str, dtype: str) -> str:
    """Return the identity of a transient: its numbers, its planes, the backend and the dtype."""
    names = (
        "template", "network", "boundary", "cell", "characteristic", "method", "duration", "limit", "scheme", "step",
        "shape",
    )  # fmt: skip
    return signature(([getattr(plan, name) for name in names], backend, dtype), planes)


def signature(values: Any, planes: dict[str, Any]) -> str:
    """Return a checksum of values and planes, equal in all processes."""
    found, checksums = sha256(), dict[int, bytes]()
    _add(found, values)
    for name, plane in sorted(planes.items()):
        if id(plane) not in checksums:
            checksums[id(plane)] = _checksum(plane)
        found.update(name.encode() + checksums[id(plane)])
    return found.hexdigest()


def _checksum(plane: Any) -> bytes:
    total = 0
    for row in range(0, plane.shape[-2], ROWS):
        total = zlib.crc32(np.ascontiguousarray(plane[..., row : row + ROWS, :]).data.cast("B"), total)
    return repr((plane.shape, np.dtype(plane.dtype).str, total)).encode()


def _add(found: Any, value: Any) -> None:
    """Add the fields of a dataclass, not its cached properties."""
    if is_dataclass(value):
        found.update(type(value).__name__.encode())
        for one in fields(value):
            _add(found, getattr(value, one.name))
    elif isinstance(value, np.ndarray):
        found.update(repr((value.shape, value.dtype.str)).encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, tuple | list):
        for entry in value:
            _add(found, entry)
    elif callable(value):
        found.update(f"{value.__module__}.{value.__qualname__}".encode())
    else:
        found.update(repr(value).encode())
