"""Runs one transient on a grid that lies on the disk, by supersteps, and returns where it ended."""

import math
from collections.abc import Collection
from contextlib import ExitStack
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.network import Frames
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_plan import check_plan, halo_of, may_sleep, reach_of, wants_small_blocks
from cnnsim.supersteps.block_task import Place
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.depth import first_depth
from cnnsim.supersteps.engine import Engine, check_workers_memory, side_of_blocks, worker_bytes
from cnnsim.supersteps.given import Planes, first_record, run_digest, write_planes
from cnnsim.supersteps.run import Supersteps
from cnnsim.supersteps.store import MASK, STATE, STATES, GridStore, Record, open_store, record_of, zarr_library
from cnnsim.support import InputError
from cnnsim.support.memory import check_memory
from cnnsim.support.values import is_stored
from cnnsim.workers import Workers, open_workers

_OWN = "each worker has one of its own, in turn if there are more"


class LargeEnd(NamedTuple):
    """Where a transient ended, as `Outcome`; ``x`` is an array or a Zarr array, ``saturated``: all cells, for good.

    ``decisions``: where it was computed, as those of a plan.
    """

    x: Any
    t: float
    settled: bool
    rate: float
    saturated: bool
    decisions: tuple[tuple[str, str], ...]


def run_large(plan: Plan, planes: Planes, where: Backend, engine: Engine, without: Collection[str]) -> LargeEnd:
    """Run a transient in supersteps; of a state that is a Zarr array, that of the result is one of the store.

    Raises:
        InputError: a plan that cannot be cut; a store of something else; a full disk, a lost scheduler (the store keeps
            the last superstep); workers that die again and again.
    """
    check_plan(plan)
    if any(isinstance(plane, Frames) for plane in planes.values()):
        raise InputError("planes that change with time on an engine; single planes, or no engine, wanted")
    zarr_library()
    sleeps = may_sleep(plan) and "sleep" not in without
    place = Place(where.name, where.dtype.name, getattr(where, "chosen_device", None))
    with ExitStack() as stack:
        workers = stack.enter_context(open_workers(engine.name, engine.workers))
        folder = engine.store or Path(stack.enter_context(TemporaryDirectory(prefix="cnnsim-store-")))
        folder = folder.absolute()  # workers may have begun in another one
        small = sleeps and wants_small_blocks(plan, place.backend, has_mask=MASK in planes)
        store, record, run = _opened(plan, planes, place, engine, folder, workers, small=small)
        steps = Supersteps(
            plan, store, record, place, workers, tuple(name for name in planes if name != "state"), engine.depth,
            sleeps, run,
        )  # fmt: skip
        try:
            steps.to_the_end()
        except (InputError, OSError) as error:
            raise _kept(error, record, plan, engine) from error
        blocks = f"blocks of {store.blocks.side} x {store.blocks.side} cells, {len(store.blocks)} of them"
        told = [("engine", f"{engine.name}: {workers.count} workers, {blocks}")]
        if devices := sorted(steps.devices - {""}):
            told.append(("devices", f"{'; '.join(devices)}; " + (_OWN if place.device is None else "as asked for")))
        return _ended(engine.store is not None and is_stored(planes["state"]), store, record, tuple(told))


def _opened(
    plan: Plan, planes: Planes, place: Place, engine: Engine, folder: Path, workers: Workers, *, small: bool
) -> tuple[GridStore, Record, str]:
    run = run_digest(plan, planes, place)
    kept = open_store(folder, run)
    record = None if kept is None else record_of(folder, Record, kept)
    if record is None:
        side = side_of_blocks(engine, plan.shape, workers.count, sleeps=small)
    else:
        side = engine.side_of_store(folder, record.side)
    dtype = np.dtype(place.dtype)
    _check_memory(plan, side, math.prod(planes["state"].shape[:-2]), list(planes), engine, workers, place, small=small)
    blocks = Blocks(plan.shape, side, plan.boundary)
    store = GridStore(folder, blocks)
    if record is None:
        try:
            record = write_planes(store, planes, dtype, link="=" not in engine.name)  # a cluster may not see them
            store.commit(record, run)
        except OSError as error:
            raise InputError(f"{folder}: {error.strerror or error}; room for the planes wanted") from error
    return store, record, run


def _check_memory(
    plan: Plan, side: int, lead: int, names: list[str], engine: Engine, workers: Workers, place: Place, *, small: bool
) -> None:  # fmt: skip
    halo = halo_of(plan, engine.depth or first_depth(side, reach_of(plan), sleeps=small), checked=True)
    needed = worker_bytes(
        plan, side, halo, lead, np.dtype(place.dtype).itemsize, len(names) - 1, has_mask=MASK in names,
        backend=place.backend,
    )  # fmt: skip
    if engine.name in ("processes", "dask"):
        check_workers_memory(needed, workers.count, side)


def run_linked(
    plan: Plan, linked: dict[str, str], shape: tuple[int, ...], place: Place, engine: Engine, side: int, folder: Path,
    workers: Workers, run: str,
) -> tuple[dict[str, Any], bool]:  # fmt: skip
    """Run a transient of planes that are stored already, by the paths of their arrays; return its end, if saturated.

    Its states are arrays of the store in ``folder``, from which it goes on if it was stopped; that of the end alone is
    left.

    Raises:
        InputError: as `run_large`.
    """
    check_plan(plan)
    dtype, blocks = np.dtype(place.dtype), Blocks(plan.shape, side, plan.boundary)
    small = wants_small_blocks(plan, place.backend, has_mask=MASK in linked)
    _check_memory(plan, side, math.prod(shape[:-2]), list(linked), engine, workers, place, small=small)
    kept = open_store(folder, run)
    store = GridStore(folder, blocks)
    if kept is None:
        for target in STATES:
            store.add(target, shape, dtype)
        record = first_record(blocks, STATE, linked)
        store.commit(record, run)
    else:
        record = record_of(folder, Record, kept)
    given, sleeps = tuple(name for name in linked if name != STATE), may_sleep(plan)
    Supersteps(plan, store, record, place, workers, given, engine.depth, sleeps, run).to_the_end()
    assert record.end is not None
    rmtree(folder / next(name for name in STATES if name != record.end["plane"]), ignore_errors=True)
    return record.end, all(record.saturated)


def _kept(error: Exception, record: Record, plan: Plan, engine: Engine) -> Exception:
    """Return the error with what the store still has."""
    what = f"{error.strerror or error}" if isinstance(error, OSError) else str(error)
    if engine.store is None:
        return InputError(what)
    t = record.step * plan.step
    return InputError(f"{what}; {engine.store} keeps superstep {record.superstep}, t = {t:g}: run again to go on")


def _ended(stays: bool, store: GridStore, record: Record, decisions: tuple[tuple[str, str], ...]) -> LargeEnd:
    assert record.end is not None
    end, state = record.end, store.array(record.end["plane"])
    if stays:
        x: Any = state
    else:
        check_memory("the result", state.nbytes, "a Zarr array as state, and a store, wanted")
        x = store.whole(end["plane"])
    t, settled, rate = (float(end[key]) for key in ("t", "settled", "rate"))
    return LargeEnd(x, t, bool(settled), rate, all(record.saturated), decisions)
