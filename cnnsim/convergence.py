"""Convergence of transients: results at a verified rest, or within an accuracy; `NotSettledError` otherwise."""

from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend, Outcome
from cnnsim.planning.plan import SETTLED_RATE
from cnnsim.result import Result
from cnnsim.solver.problem import TransientProblem
from cnnsim.solver.rest_distance import SETTLED_DISTANCE
from cnnsim.solver.solve import decision, solve
from cnnsim.solver.tolerance import Tolerance
from cnnsim.solver.verify_settled import verify_settled
from cnnsim.support import InputError


class NotSettledError(InputError):
    """A transient was to settle and did not within its limit; ``result`` is where it ended."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> Any:
        """Pickle both arguments: a pool of processes that cannot read an error of its worker waits for ever."""
        return type(self), (str(self), self.result)


def accurate_result(problem: TransientProblem, where: Backend, tolerance: Tolerance) -> Result:
    """Return the result of a transient to an accuracy.

    Raises:
        NotSettledError: it was to settle and did not.
    """
    found = solve(problem, where, tolerance)
    how, plan = decision(problem.plan, tolerance, problem.planes[0].shape), found.plan
    plan = plan if how in plan.decisions else replace(plan, decisions=(*plan.decisions, how))
    result = Result(
        found.x, found.t, found.settled, found.rate, plan, None, found.error if found.settled else nan,
        np.argwhere(found.undecided), found.how, found.error,
    )  # fmt: skip
    if plan.duration == "settled" and not found.settled:
        raise NotSettledError(
            f"template {plan.template.name!r} has not settled after {found.t:g} time constants within {tolerance}; "
            "give a duration, or a higher limit",
            result,
        )
    return result


def settled_result(result: Result, where: Backend, outcome: Outcome, u: Any, bias: Any, mask: Any) -> Result:
    """Return the result of a run that was to settle, with its outputs within `SETTLED_DISTANCE` of the rest.

    Raises:
        NotSettledError: they are not.
    """
    name = f"template {result.plan.template.name!r}"
    if not result.settled:
        raise NotSettledError(
            f"{name} has not settled after {result.t:g} time constants: |dx/dt| is still "
            f"{result.rate:.3g} somewhere; give a duration, or a higher limit",
            result,
        )
    verified, ending = verify_settled(where, result.plan, outcome, u, bias, mask, SETTLED_DISTANCE)
    if ending.x is not None:
        result = replace(result, x=ending.x, t=verified.t, settled=verified.settled, rate=verified.rate)
    result = replace(result, distance=ending.distance, undecided=np.argwhere(ending.undecided), how=ending.how)
    if not result.settled:
        away = "far" if result.distance == inf else f"{result.distance:.2g}"
        raise NotSettledError(
            f"{name} slowed down to |dx/dt| <= {SETTLED_RATE:g}, but after {result.t:g} time constants may be {away} "
            "from its end; give a duration, or a higher limit",
            result,
        )
    return result
