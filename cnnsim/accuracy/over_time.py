"""States over time to an accuracy: each by runs of its own, as the steps that reach it are no steps of another."""

from dataclasses import replace

import numpy as np

from cnnsim.accuracy.reach import reach
from cnnsim.accuracy.repeatable import Reached, Repeatable
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend
from cnnsim.recording import check_times
from cnnsim.support import Floats, InputError
from cnnsim.trajectories import CellIndex, Trajectory


def reached_at(transient: Repeatable, where: Backend, wanted: Wanted, t: float) -> tuple[float, Reached]:
    """Return a time and the state there within an accuracy, whatever the transient's duration is.

    The time is ``t``, or the step next to it where delays, sequences or discrete time leave only whole steps.
    """
    plan = transient.plan
    if transient.timed or plan.cell == "discrete-time":
        t = round(t / plan.step) * plan.step
    return t, reach(replace(transient, plan=replace(plan, duration=t)), where, wanted)


def recorded_within(
    transient: Repeatable, where: Backend, accuracy: Wanted, wanted: tuple[CellIndex, ...] | Floats
) -> tuple[Trajectory, float]:
    """Return states at times (from `parse_record`), and the largest error of them by the runs' own estimates.

    Raises:
        InputError: cells; a time after the end of a fixed duration.
    """
    if not isinstance(wanted, np.ndarray):
        raise InputError(
            "record: cells are kept at every step, and runs to an accuracy have none in common; times, or cells with a "
            "scheme and a step, wanted"
        )
    check_times(transient.plan, wanted)
    found = dict(reached_at(transient, where, accuracy, float(t)) for t in wanted)
    x = np.array([one.x for one in found.values()])
    return Trajectory(np.array(list(found)), x, transient.plan.output(x)), max(one.error for one in found.values())
