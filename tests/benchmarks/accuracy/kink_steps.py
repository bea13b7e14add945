"""Two ideas tried: steps that end exactly on kinks, and an exponential integrator of order 2, against the tables."""

from typing import Any

import numpy as np

from cnnsim.accuracy.linear.exact_flow import exact_flow
from cnnsim.accuracy.linear.system import LinearSystem, linear_system
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
    system, x, duration = system_of(given)
    return exact_flow(system, x, 0 * x, duration, 10**6).evaluations
