"""Transients of large grids on an engine: the planes handed over, and the result as without one."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.accuracy.settle import SETTLED_DISTANCE, contraction_bound
from cnnsim.backends.base import Backend, Outcome
from cnnsim.ended import NotSettledError, ended
from cnnsim.network import AnyTemplate
from cnnsim.result import Result
from cnnsim.supersteps.engine import Engine, parse_engine
from cnnsim.supersteps.large import run_large
from cnnsim.support import InputError
from cnnsim.support.memory import LARGE
from cnnsim.support.values import is_grey, is_stored, stored_plane
from cnnsim.task import load, make_task

PLANES = ("state", "input", "bias", "mask")


def run_on_engine(
    template: AnyTemplate, where: Backend, engine: str | Engine, store: str | Path | None, choices: dict[str, Any]
) -> Result:
    """Run a transient in supersteps; planes may be Zarr arrays, and of such a state the result's is one as well.

    Raises:
        InputError: as `make_task` and `cnnsim.supersteps.large.run_large`; an accuracy, which needs several runs.
        NotSettledError: as `run_transient`.
    """
    stored = {name: choices[name] for name in PLANES if is_stored(choices.get(name))}
    for name in stored.keys() - {"mask"}:  # above 0 is held there, whatever the numbers
        stored_plane(name, stored[name])
    told = {name: np.broadcast_to(np.ones(1), plane.shape) for name, plane in stored.items()}  # its shape is checked
    task = make_task(template, **{**choices, **told})
    if "state" in stored:
        grey = make_task(template, **{**choices, **told, "state": np.broadcast_to(np.array([0.5]), task.state.shape)})
        if (grey.plan.scheme, grey.plan.step) != (task.plan.scheme, task.plan.step) and is_grey(stored["state"]):
            task = grey
    if task.accuracy is not None:
        raise InputError("an accuracy on an engine: several runs are made; give scheme and step, or no engine")
    planes = {name: getattr(task, name) for name in PLANES if getattr(task, name) is not None} | stored
    if not template.reads_input:
        planes.pop("input", None)
    end = run_large(task.plan, planes, where, parse_engine(engine, store), choices.get("without", ()))
    plan = replace(task.plan, decisions=(*task.plan.decisions, *end.decisions))
    result = Result(end.x, end.t, end.settled, end.rate, plan)
    if task.plan.duration != "settled":
        return result
    if end.x.size <= LARGE:
        x = where.load(np.asarray(end.x[...]), "lam")
        u, bias, mask = (
            None if name not in planes else np.broadcast_to(planes[name][...], end.x.shape) for name in PLANES[1:]
        )
        outcome = Outcome(x, end.t, end.settled, end.rate)
        held = None if mask is None else where.load(np.asarray(mask), "llm")
        return ended(result, where, outcome, load(where, u), load(where, bias), held)
    if not end.settled:
        raise NotSettledError(
            f"template {task.plan.template.name!r} has not settled after {end.t:g} time constants: |dx/dt| is still "
            f"{end.rate:.3g} somewhere; give a duration, or a higher limit",
            result,
        )
    if end.saturated or task.plan.cell == "discrete-time":
        return replace(result, distance=0.0, how="no output can change")
    if task.plan.method == "closed form":
        return replace(result, distance=0.0, how="each cell has an exact solution")
    if (bound := contraction_bound(task.plan, end.rate)) <= SETTLED_DISTANCE:
        return replace(result, distance=bound, how="A is a contraction: |dx/dt| / (1 - sum|A|)")
    return replace(result, how="|dx/dt| is small everywhere; how far the end is, is not looked at on so large a grid")
