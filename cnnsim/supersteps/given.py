"""Planes of a large grid, as arrays or as Zarr arrays, brought into a store block by block and told from others."""

from dataclasses import fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_task import Place
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.identity import identity
from cnnsim.supersteps.shards import can_be_read
from cnnsim.supersteps.store import INPUT, MASK, STATE, STATES, GridStore, Record
from cnnsim.support import Array, InputError
from cnnsim.support.progress import watcher

Planes = dict[str, Any]
"""The planes by name: "state", and perhaps "input", "bias", "mask"; arrays, or Zarr arrays, of one shape."""


def run_digest(plan: Plan, planes: Planes, place: Place) -> str:
    """Return what tells a run from others: its numbers, its planes, and where it is computed."""
    told = sha256()
    for name in (
        "template", "network", "boundary", "cell", "characteristic", "method", "duration", "limit", "scheme", "step",
        "shape",
    ):  # fmt: skip
        _add(told, getattr(plan, name))
    _add(told, (place.backend, place.dtype))
    _add_planes(told, planes)
    return told.hexdigest()


def signature(values: Any, planes: Planes) -> str:
    """Return what tells a run of a program from others: its values, and its planes."""
    told = sha256()
    _add(told, values)
    _add_planes(told, planes)
    return told.hexdigest()


def _add_planes(told: Any, planes: Planes) -> None:
    seen: dict[int, bytes] = {}
    for name, plane in sorted(planes.items()):
        if id(plane) not in seen:
            seen[id(plane)] = identity(plane)
        told.update(name.encode() + seen[id(plane)])


def _add(told: Any, value: Any) -> None:
    """Add the fields of a value; not what it has worked out of them meanwhile."""
    if is_dataclass(value):
        told.update(type(value).__name__.encode())
        for one in fields(value):
            _add(told, getattr(value, one.name))
    elif isinstance(value, np.ndarray):
        told.update(repr((value.shape, value.dtype.str)).encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, tuple | list):
        for entry in value:
            _add(told, entry)
    elif callable(value):
        told.update(f"{value.__module__}.{value.__qualname__}".encode())
    else:
        told.update(repr(value).encode())


def write_planes(store: GridStore, planes: Planes, dtype: np.dtype[Any], *, link: bool) -> Record:
    """Bring the planes into the store, and return the record of step 0.

    ``link``: Zarr arrays that the tasks can read as they are stay where they are.

    Raises:
        InputError: a plane that is not finite; of one that stays where it is the tasks say it.
    """
    state, blocks, linked = planes[STATE], store.blocks, dict[str, str]()
    shared = planes.get(INPUT) is state
    for name, plane in planes.items():
        if name == STATE and shared:
            continue
        whole = tuple(plane.shape) == tuple(state.shape)  # else a plane (rows, cols) stands for all layers or grids
        if link and whole and name != MASK and hasattr(plane, "store_path") and can_be_read(plane, dtype):
            linked[name] = str((Path(plane.store.root) / plane.path).absolute())
            continue
        target = STATES[0] if name == STATE else name
        store.add(target, state.shape, bool if name == MASK else dtype)
        for block in range(len(blocks)):
            (r0, r1), (c0, c1) = area = blocks.area(block)
            values = _values(name, plane[..., r0:r1, c0:c1], dtype, area)
            store.write(target, area, np.broadcast_to(values, (*state.shape[:-2], *values.shape[-2:])))
            if (told := watcher()) is not None:
                told((block + 1) / len(blocks), f"{name} to {store.folder}")
    first = INPUT if shared else STATE if STATE in linked else STATES[0]
    for target in STATES:
        if target != first:
            store.add(target, state.shape, dtype)
    return first_record(blocks, first, linked)


def first_record(blocks: Blocks, first: str, linked: dict[str, str]) -> Record:
    """Return the record of step 0, with the states of all blocks in the array ``first``."""
    n = len(blocks)
    return Record(blocks.side, 0, 0, [first] * n, [0] * n, [False] * n, [float("inf")] * n, [None] * n, linked)


def _values(name: str, part: Any, dtype: np.dtype[Any], area: Any) -> Array:
    values = np.asarray(part)
    if name == MASK:
        return values > 0
    if values.dtype == bool:
        return np.where(values, dtype.type(1), dtype.type(-1))
    if not np.isfinite(values).all():
        raise InputError(f"{name} holds what is not finite from row {area[0][0]}, column {area[1][0]} on")
    return values.astype(dtype, copy=False)
