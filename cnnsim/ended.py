"""Ends of transients: seen to their rest, or run to an accuracy, before they are called settled."""

from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from cnnsim.accuracy.at_rest import seen_to_the_end
from cnnsim.accuracy.reach import decided, reach
from cnnsim.accuracy.repeatable import Repeatable
from cnnsim.accuracy.settle import SETTLED_DISTANCE
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend, Outcome
from cnnsim.planning.plan import SETTLED_RATE
from cnnsim.result import Result
from cnnsim.support import InputError


class NotSettledError(InputError):
    """A transient was to settle and did not within its limit; ``result`` has what there is."""

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> Any:
        """Both arguments: a pool of processes that could not read an error of its worker would wait for ever."""
        return type(self), (str(self), self.result)


def reached(transient: Repeatable, where: Backend, wanted: Wanted) -> Result:
    """Return the result of a run to an accuracy.

    Raises:
        NotSettledError: it was to settle and did not.
    """
    found = reach(transient, where, wanted)
    said, plan = decided(transient.plan, wanted, transient.planes[0].shape), found.plan
    plan = plan if said in plan.decisions else replace(plan, decisions=(*plan.decisions, said))
    result = Result(
        found.x, found.t, found.settled, found.rate, plan, None, found.error if found.settled else nan,
        np.argwhere(found.undecided), found.how, found.error,
    )  # fmt: skip
    if plan.duration == "settled" and not found.settled:
        raise NotSettledError(
            f"template {plan.template.name!r} has not settled after {found.t:g} time constants within {wanted}; "
            "give a duration, or a higher limit",
            result,
        )
    return result


def ended(result: Result, where: Backend, outcome: Outcome, u: Any, bias: Any, mask: Any) -> Result:
    """Return the result of a run that was to settle only when its outputs are as near to their end as promised.

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
    seen, ending = seen_to_the_end(where, result.plan, outcome, u, bias, mask, SETTLED_DISTANCE)
    if ending.x is not None:
        result = replace(result, x=ending.x, t=seen.t, settled=seen.settled, rate=seen.rate)
    result = replace(result, distance=ending.distance, undecided=np.argwhere(ending.undecided), how=ending.how)
    if not result.settled:
        raise NotSettledError(
            f"{name} moves no faster than {SETTLED_RATE:g} after {result.t:g} time constants, but may be "
            f"{result.distance:.2g} from its end; give a duration, or a higher limit",
            result,
        )
    return result
