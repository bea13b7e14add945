"""Two ideas tried: steps that end exactly on kinks, and an exponential integrator of order 2, against the tables."""

from typing import Any

import numpy as np

from cnnsim.accuracy import exact_flow
from cnnsim.accuracy.system import LinearSystem, linear_system
from cnnsim.backends.reference.drive import control
from cnnsim.support import Floats
from cnnsim.task import make_task


def system_of(given: dict[str, Any]) -> tuple[LinearSystem, Floats, float]:
    """The linear system of a transient, its state in one row, and its duration."""
    task = make_task(**given)
    plan = task.plan
    drive = control(plan, task.state, task.input, task.bias)  # type: ignore[arg-type]  # no sequences here
    system = linear_system(plan.template.feedback_taps, plan.shape, plan.boundary)
    return system.with_planes(drive.ravel(), np.ones(drive.size, bool)), task.state.ravel(), float(plan.duration)


def exponential_heun(system: LinearSystem, x: Floats, duration: float, steps: int) -> tuple[Floats, int]:
    """Steps of ETD2RK (Cox and Matthews, J. Comput. Phys. 176 (2002) 430, eq. 22): the leak exactly, A*y by a line."""
    h = duration / steps
    gain, slope = -np.expm1(-h), (np.exp(-h) - 1 + h) / h
    for _ in range(steps):
        before = system.matrix @ x.clip(-1, 1) + system.drive
        stage = x * np.exp(-h) + gain * before
        x = stage + slope * (system.matrix @ stage.clip(-1, 1) + system.drive - before)
    return x, 2 * steps


def kink_evaluations(given: dict[str, Any]) -> int:
    """How often A*y is evaluated on the way from kink to kink."""
    counted, series = [0], exact_flow._series

    def counting(*args: Any) -> Floats:
        counted[0] += exact_flow.TERMS
        return series(*args)

    exact_flow._series = counting  # type: ignore[assignment]  # the same function, counted
    try:
        exact_flow.exact_state(*system_of(given))
    finally:
        exact_flow._series = series
    return counted[0]
