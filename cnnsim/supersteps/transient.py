"""Transients of large grids on an engine: planes are written to a store, stepped block by block, and read back."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend, Outcome
from cnnsim.convergence import NotSettledError, settled_result
from cnnsim.network import ZERO_FLUX, AnyTemplate, Frames, Sides
from cnnsim.network.sides import parse_run_boundary
from cnnsim.planning.plan import Plan
from cnnsim.result import Result
from cnnsim.solver.rest_distance import SETTLED_DISTANCE, contraction_bound
from cnnsim.supersteps.block_plan import check_plan
from cnnsim.supersteps.block_task import MASK, STATE, Place
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import LARGEST, Engine, check_worker_memory, parse_engine, side_of_blocks
from cnnsim.supersteps.identity import run_identity
from cnnsim.supersteps.run import STATES, Record, Supersteps
from cnnsim.supersteps.store import GridStore, zarr_library
from cnnsim.support import InputError
from cnnsim.support.memory import LARGE, check_memory
from cnnsim.support.values import is_grey, is_stored, stored_plane
from cnnsim.task import Task, load, make_task
from cnnsim.workers import Workers, open_workers

PLANES = ("state", "input", "bias", "mask")
KIND = "cnnsim supersteps"


def run_on_engine(
    template: AnyTemplate, where: Backend, engine: str | Engine, store: str | Path | None, choices: dict[str, Any]
) -> Result:
    """Run a transient block by block. Planes may be Zarr arrays; with such a state and a store the result is one.

    Raises:
        InputError: as `make_task`; an accuracy, which needs several runs; a transient that cannot be computed block by
            block; a store of another run; a full disk, a lost scheduler, workers that die (the store keeps the last
            superstep).
        NotSettledError: as `run_transient`.
    """
    if isinstance(parse_run_boundary(choices.get("boundary", ZERO_FLUX)), Sides):
        raise InputError("a boundary value for each side on an engine; one value for all sides, or no engine, wanted")
    task, planes = _task(template, choices)
    if task.accuracy is not None:
        raise InputError(
            "accuracy with an engine: an accuracy needs several runs; scheme and step, or no engine, wanted"
        )
    if any(isinstance(plane, Frames) for plane in planes.values()):
        raise InputError("planes that change with time on an engine; single planes, or no engine, wanted")
    if not template.reads_input:
        planes.pop("input", None)
    check_plan(task.plan)
    zarr_library()
    at = parse_engine(engine, store)
    with ExitStack() as stack:
        folder = at.store or Path(stack.enter_context(TemporaryDirectory(prefix="cnnsim-store-")))
        workers = stack.enter_context(open_workers(at.name, at.workers))
        steps = _steps(task.plan, planes, where, at, folder.absolute(), workers)
        with _kept(steps, at):
            steps.run()
        state = zarr_library().open_array(steps.state, mode="r")
        if at.store is None or not is_stored(planes["state"]):
            check_memory("the result", state.nbytes, "a Zarr array as state, and a store, wanted")
            state = state[...]
    side, record = steps.record.side, steps.record
    decisions = [("engine", f"{at.name}: {workers.count} workers, blocks of {side} x {side} cells")]
    if steps.devices:
        decisions.append(("devices", "; ".join(sorted(steps.devices))))
    plan = replace(task.plan, decisions=(*task.plan.decisions, *decisions))
    result = Result(state, steps.time, record.settled, record.rate, plan)
    return result if plan.duration != "settled" else _settled(result, where, planes, saturated=record.saturated)


def _task(template: AnyTemplate, choices: dict[str, Any]) -> tuple[Task, dict[str, Any]]:
    """Return the task and its planes; for Zarr arrays the task is made with planes of ones of their shapes."""
    stored = {name: choices[name] for name in PLANES if is_stored(choices.get(name))}
    for name in stored.keys() - {"mask"}:  # a mask of any dtype holds the cells above 0
        stored_plane(name, stored[name])
    ones = {name: np.broadcast_to(np.ones(1), plane.shape) for name, plane in stored.items()}
    task = make_task(template, **{**choices, **ones})
    if "state" in stored:
        half = np.broadcast_to(np.array([0.5]), task.state.shape)
        grey = make_task(template, **{**choices, **ones, "state": half})
        if (grey.plan.scheme, grey.plan.step) != (task.plan.scheme, task.plan.step) and is_grey(stored["state"]):
            task = grey
    return task, {name: getattr(task, name) for name in PLANES if getattr(task, name) is not None} | stored


def _steps(
    plan: Plan, planes: dict[str, Any], where: Backend, engine: Engine, folder: Path, workers: Workers
) -> Supersteps:
    """Return the supersteps of a run, at their start or as far as the store in a folder has them."""
    place = Place(where.name, where.dtype.str, getattr(where, "chosen_device", None))
    run = "" if engine.store is None else run_identity(plan, planes, where.name, where.dtype.str)
    store = GridStore(folder, run, KIND)
    shape = tuple(planes["state"].shape)
    if store.record is None:
        record = Record(side_of_blocks(engine, shape, workers.count))
    else:
        record = Record(**store.record)
        engine.side_of_store(folder, record.side)
    check_worker_memory(engine, plan, record.side, shape, where.dtype, set(planes), where.name, workers.count)
    local = engine.name == "processes"
    present = {name: _in_place(plane, shape, where.dtype) for name, plane in planes.items()} if local else {}
    new = {name: folder / (STATES[0] if name == STATE else name) for name in planes}
    paths = {name: present.get(name) or new[name] for name in planes}
    if planes.get("input") is planes[STATE]:  # one array for both
        paths[STATE] = paths["input"]
    if store.record is None:
        blocks = Blocks(plan.shape, record.side, plan.boundary)
        try:
            for name in planes:
                if paths[name] == new[name]:
                    store.write_plane(new[name].name, planes[name], shape, where.dtype, blocks, logic=name == MASK)
            store.commit(vars(record))
        except OSError as error:
            raise InputError(f"{folder}: {error.strerror or error}; space for the planes wanted") from error
    return Supersteps(plan, store, record, paths, place, engine, workers)


def _in_place(plane: Any, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Path | None:
    """Return the path of a Zarr array on this machine whose chunks the workers can read as they are, else None."""
    if not is_stored(plane) or not hasattr(plane.store, "root") or plane.dtype != dtype or plane.shape != shape:
        return None
    return (Path(plane.store.root) / plane.path).absolute() if max(plane.chunks[-2:]) <= LARGEST else None


@contextmanager
def _kept(steps: Supersteps, engine: Engine) -> Iterator[None]:
    """Add to an error what the store keeps."""
    try:
        yield
    except (InputError, OSError) as error:
        what = (error.strerror if isinstance(error, OSError) else None) or str(error)
        if engine.store is not None:
            t = steps.record.step * steps.plan.step
            what += f"; {engine.store} keeps superstep {steps.record.superstep}, t = {t:g}: run again to resume"
        raise InputError(what) from error


def _settled(result: Result, where: Backend, planes: dict[str, Any], *, saturated: bool) -> Result:
    """Return the result of a run until settled with its distance from the end, not computed for large grids.

    Raises:
        NotSettledError: as `run_transient`.
    """
    if result.x.size <= LARGE:
        u, bias, mask = (
            np.broadcast_to(planes[name][...], result.x.shape) if name in planes else None for name in PLANES[1:]
        )
        outcome = Outcome(
            where.load(np.asarray(result.x[...]), "lam"), result.t, result.settled, result.rate, saturated
        )
        held = None if mask is None else where.load(np.asarray(mask), "llm")
        return settled_result(result, where, outcome, load(where, u), load(where, bias), held)
    plan = result.plan
    if not result.settled:
        raise NotSettledError(
            f"template {plan.template.name!r} has not settled after {result.t:g} time constants: |dx/dt| is still "
            f"{result.rate:.3g} somewhere; give a duration, or a higher limit",
            result,
        )
    if saturated or plan.cell == "discrete-time":
        return replace(result, distance=0.0, how="no output can change")
    if plan.method == "closed form":
        return replace(result, distance=0.0, how="each cell has an exact solution")
    if (bound := contraction_bound(plan, result.rate)) <= SETTLED_DISTANCE:
        return replace(result, distance=bound, how="A is a contraction: |dx/dt| / (1 - sum|A|)")
    return replace(result, how="|dx/dt| is small everywhere; the distance from the end is not computed on large grids")
