"""Recording of transients: states at given times, or of given cells at every step, by the steps of the run."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.planning.step import DEFAULT_STEP
from cnnsim.support import Array, Floats, InputError
from cnnsim.trajectories import CellIndex, Trajectory

Record = Sequence[float] | Sequence[CellIndex] | Array
"""Times [time constants], or cells (row, column)."""

Run = Callable[[Array, Plan], Array]
"""Runs a plan from a state and returns the state at its end."""

_LONGEST = 1000.0
"""Time constants after which the recording of a closed form ends: a cell with a = 1 + 1e-3 takes as long."""


def parse_record(record: Record, shape: tuple[int, ...]) -> tuple[CellIndex, ...] | Floats:
    """Parse what to record on planes of ``shape``: cells, or times in ascending order.

    Raises:
        InputError: neither times nor cells, a time below 0, a cell outside the grid.
    """
    try:
        values = np.asarray(record)
    except ValueError as error:
        raise _neither(record) from error
    if values.ndim == 2 and values.shape[1] == 2 and len(values) and values.dtype.kind in "iu":
        cells = tuple((int(row), int(col)) for row, col in values)
        for row, col in cells:
            if not (0 <= row < shape[-2] and 0 <= col < shape[-1]):
                raise InputError(
                    f"record: cell ({row}, {col}); rows 0 to {shape[-2] - 1}, columns 0 to {shape[-1] - 1}"
                )
        return cells
    if values.ndim != 1 or not len(values) or values.dtype.kind not in "iuf":
        raise _neither(record)
    times: Floats = np.unique(values.astype(np.float64))
    if not (np.isfinite(times).all() and times[0] >= 0):
        raise InputError(f"record: times from {times[0]:g} to {times[-1]:g}; finite ones from 0 on wanted")
    return times


def check_times(plan: Plan, times: Floats) -> None:
    """Refuse times, in ascending order, after the end of a fixed duration.

    Raises:
        InputError: a time is later; the message has both times.
    """
    if plan.duration != "settled" and times[-1] > plan.duration * (1 + 1e-9):
        raise InputError(f"record: time {times[-1]:g} after the end of the run; 0 to {plan.duration:g} wanted")


def _neither(record: Any) -> InputError:
    return InputError(f"record = {record!r}; times such as [0, 0.5, 1], or cells such as [(3, 4)], wanted")


def recorded(
    plan: Plan, state: Array, run: Run, wanted: tuple[CellIndex, ...] | Floats, end: float, output: Array,
    *, sequences: bool,
) -> Trajectory:  # fmt: skip
    """Return states at times, or of cells at every step up to ``end``: the states of the run itself.

    A time is rounded to the nearest step, and the trajectory has the time of that step. Closed forms and the adaptive
    scheme give every time exactly. A settled network is run on to times after its end.

    Arguments: ``state`` x(0), in the backend's dtype; ``wanted`` from `parse_record`; ``output`` y at the end;
    ``sequences`` whether planes change with time.

    Raises:
        InputError: a time after the end of a fixed duration.
    """
    cells, asked = (None, wanted) if isinstance(wanted, np.ndarray) else (wanted, None)
    if asked is not None:
        check_times(plan, asked)
    rows, cols = ([place[axis] for place in cells or ()] for axis in (0, 1))

    def kept(x: Array) -> Array:
        return x.copy() if cells is None else x[..., rows, cols]

    times: Array
    if plan.scheme is None and plan.cell != "discrete-time":
        times = _watched(plan, state, run, kept, end, kept(output)) if asked is None else asked
        found = [kept(run(state, replace(plan, duration=float(t))) if t else state) for t in times]
    else:
        last = round(end / plan.step)
        steps = np.arange(last + 1) if asked is None else np.unique(np.rint(asked / plan.step).astype(np.int64))
        times = steps * plan.step
        restart = sequences or (plan.network is not None and bool(delays_of(plan.network)))
        restart |= plan.cell == "discrete-time" and not plan.characteristic.keeps_outputs
        found = [kept(x) for x in _states(plan, state, run, [int(step) for step in steps], restart)]
    x = np.array(found)
    return Trajectory(np.asarray(times, np.float64), x, plan.output(x), cells)


def _states(plan: Plan, state: Array, run: Run, steps: Sequence[int], restart: bool) -> Iterator[Array]:
    """Yield the states after the given numbers of steps.

    ``restart``: each run begins at x(0), because with delays one state does not determine the next.
    """

    @cache  # a backend prepares a plan once
    def of(count: int) -> Plan:
        return replace(plan, duration=count * plan.step, savings=plan.savings - {"sleep"})

    x, done = state, 0
    for step in steps:
        if step > done:
            x = run(state, of(step)) if restart else run(x, of(step - done))
            done = step
        yield x


def _watched(plan: Plan, state: Array, run: Run, kept: Callable[[Array], Array], end: float, y: Array) -> Floats:
    """Return the times at which cells without steps are recorded: up to the end, or until their outputs are final."""
    if not np.isfinite(end):
        end = 5.0
        while end < _LONGEST and np.abs(plan.output(kept(run(state, replace(plan, duration=end)))) - y).max() > 1e-3:
            end *= 2
    return np.linspace(0.0, end, max(2, round(end / DEFAULT_STEP) + 1)) if end else np.zeros(1)
