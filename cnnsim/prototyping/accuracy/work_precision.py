"""Work and precision of one transient: its error against evaluations and time, by scheme, step, dtype and backend."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim import backends
from cnnsim.backends.base import NotFiniteError
from cnnsim.planning.scheme import SCHEMES, find_scheme
from cnnsim.solver.solve import solve
from cnnsim.solver.step_refinement import longest_step
from cnnsim.solver.tolerance import EXACT
from cnnsim.support import Floats, InputError
from cnnsim.task import make_task

STEPS = tuple(0.8 * 0.5**k for k in range(10))


@dataclass(frozen=True)
class PrecisionRow:
    """One run: its setting, the largest error of a state, the share of right signs, evaluations of A*y, seconds."""

    backend: str
    dtype: str
    scheme: str
    step: float
    error: float
    signs: float
    evaluations: int
    seconds: float


def settings(names: Sequence[str], most: int) -> Iterator[tuple[str, str, str, float]]:
    """Yield backend, dtype, scheme and step of all runs, the longest steps first."""
    for name in names:
        for dtype in ("float64",) if name == "reference" else ("float32", "float64"):
            for scheme in SCHEMES:
                for step in STEPS[:most]:
                    yield name, dtype, scheme, step


def measured(
    given: dict[str, Any], exact: Floats, setting: tuple[str, str, str, float], rounds: int = 3
) -> PrecisionRow | None:
    """Return the row of a setting, with the best time of ``rounds`` runs; None if the step is unstable or invalid.

    Arguments: ``given`` as `cnnsim.task.make_task` takes it, with a duration; ``exact`` the state at its end.
    """
    name, dtype, scheme, step = setting
    try:
        plan = make_task(**given).plan
        if plan.method == "general" and step > longest_step(plan, find_scheme(scheme)):
            return None
        task = make_task(**given, scheme=scheme, step=step)
        where = backends.get(name, dtype)
        best = np.inf
        for _ in range(rounds):
            start = time.perf_counter()
            x = where.read(task.start(where).x)
            best = min(best, time.perf_counter() - start)
    except (InputError, NotFiniteError):
        return None
    error = float(np.abs(x - exact).max())
    signs = float((np.sign(task.plan.output(x)) == np.sign(task.plan.output(exact))).mean())
    stages = len(task.plan.scheme.b) if task.plan.scheme else 1
    return PrecisionRow(name, dtype, scheme, task.plan.step, error, signs, task.plan.steps * stages, float(best))


def reference_state(given: dict[str, Any]) -> tuple[Floats, str]:
    """Return the state at the end of a transient with an error far below those compared, and how it was found.

    A linear template is solved to 1e-10; of any other two runs by short steps are extrapolated.
    """
    task = make_task(**given, accuracy="exact")
    where, ends = backends.get("cpu", "float64"), []
    if task.plan.method in ("stepped", "closed form") and task.accuracy is not None:
        found = solve(task.problem(), where, task.accuracy)
        return found.x, f"solved to {max(found.error, EXACT):.0e}"
    for step in (1 / 500, 1 / 1000):
        fine = make_task(**given, scheme="heun", step=step)
        ends.append(where.read(fine.start(where).x))
    return ends[1] + (ends[1] - ends[0]) / 3, f"heun by 1/500 and 1/1000, {np.abs(ends[1] - ends[0]).max():.0e} apart"
