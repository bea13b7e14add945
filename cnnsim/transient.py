"""run_transient: runs the transient of a template on a backend; trajectory: its outputs over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from numpy.typing import ArrayLike

from cnnsim import backends
from cnnsim.backends.base import Backend
from cnnsim.convergence import accurate_result, settled_result
from cnnsim.network import AnyTemplate
from cnnsim.recording import Record, parse_record
from cnnsim.result import Result
from cnnsim.solver.solve import record_solutions
from cnnsim.support import Array, InputError
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_number, is_whole
from cnnsim.task import Dtype, TaskOptions, load, make_task

if TYPE_CHECKING:
    from cnnsim.supersteps.engine import Engine


@spelled(TaskOptions)
def run_transient(
    template: AnyTemplate,
    *,
    state: ArrayLike,
    backend: str | Backend = "cpu",
    dtype: Dtype | None = None,
    threads: int | None = None,
    record: Record | None = None,
    engine: str | Engine | None = None,
    store: str | Path | None = None,
    **choices: Unpack[TaskOptions],
) -> Result:
    """Run one template from x(0) = ``state`` with u = ``input`` and return where it ends.

    Arguments: ``choices`` are input, bias, mask, boundary, duration, cell, scheme, step, limit, without, accuracy, as
    in `make_task`; ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its own;
    ``threads`` of the cpu backend, None for as many as pay; ``record`` times [time constants], or cells (row, column)
    to record at every step: the result then has a ``trajectory``, from the steps of the run, or with an accuracy
    (times only) from a solution for each time;
    ``engine`` for grids that are larger than the memory, or for other machines: "processes", "dask=ADDRESS" or
    an `Engine`, with the folder of its ``store``. Planes may be Zarr arrays then, and so is the result of such a state.

    Raises:
        InputError: as `make_task`; no such backend; times or cells that cannot be recorded.
        NotSettledError: the network did not settle within ``limit``; the error carries the result.
    """
    if engine is not None or store is not None:
        from cnnsim.supersteps.transient import run_on_engine  # needs the extra "scale"

        if record is not None:
            raise InputError("record on an engine; states of large grids are not kept: no engine, or no record, wanted")
        where = backends.chosen(backend, dtype, threads)
        return run_on_engine(template, where, engine or "processes", store, {**choices, "state": state})
    task = make_task(template, state=state, **choices)
    wanted = None if record is None else parse_record(record, task.state.shape)
    where = backends.chosen(backend, dtype, threads)
    if task.accuracy is not None:
        problem = task.problem()
        path, error = (None, 0.0) if wanted is None else record_solutions(problem, where, task.accuracy, wanted)
        result = accurate_result(problem, where, task.accuracy)
        return replace(result, trajectory=path, error=max(result.error, error))
    outcome = task.start(where)
    result = Result(where.read(outcome.x, copy=False), outcome.t, outcome.settled, outcome.rate, task.plan)
    if wanted is not None:
        result = replace(result, trajectory=task.recorded(where, wanted, result))
    if task.plan.duration != "settled":
        return result
    mask = None if task.mask is None else where.load(task.mask, "llm")
    return settled_result(result, where, outcome, load(where, task.input), load(where, task.bias), mask)


@spelled(TaskOptions)
def trajectory(
    template: AnyTemplate,
    *,
    state: ArrayLike,
    until: float,
    frames: int,
    backend: str | Backend = "cpu",
    dtype: Dtype | None = None,
    threads: int | None = None,
    **choices: Unpack[TaskOptions],
) -> Iterator[tuple[float, Array]]:
    """Yield (t, y) at ``frames`` + 1 evenly spaced times from 0 to ``until``; ``duration`` does not matter.

    Arguments and errors: as `run_transient`.
    """
    if not is_whole(frames) or frames < 1:
        raise InputError(f"frames {frames!r}; a whole number above 0 wanted")
    if not is_number(until) or not 0 <= until < math.inf:
        raise InputError(f"until {until!r}; a number of time constants >= 0 wanted")
    task = make_task(template, state=state, **choices).owned()
    where = backends.chosen(backend, dtype, threads)
    yield 0.0, task.plan.output(where.read(where.load(task.state, "lam")))
    for t, x in task.states(where, until, frames):
        yield t, task.plan.output(x)
