"""A template step run to an accuracy: the planes read, the transient repeated until its error is small enough."""

import numpy as np

from cnnsim.accuracy.repeatable import Repeatable
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend, Outcome, Plane
from cnnsim.ended import reached
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


def to_accuracy(backend: Backend, plan: Plan, wanted: Wanted, *planes: Plane | None) -> Plane:
    """Run a transient of state, input, bias and mask to an accuracy, in float64 where it must be; return its state."""
    read = [None if plane is None else backend.read(plane) for plane in planes]
    x, u, bias = (None if plane is None else plane.astype(np.float64) for plane in read[:3])

    def start(where: Backend, again: Plan, pushed: Array | None = None, /) -> Outcome:
        given = (x if pushed is None else pushed, u, bias)
        state, shown, added = (None if plane is None else where.load(plane, "lam") for plane in given)
        return where.transient(again, state, shown, added, None if read[3] is None else where.load(read[3], "llm"))

    found = reached(Repeatable(plan, start, (x, u, bias, read[3])), backend, wanted)
    return backend.load(found.x.astype(backend.dtype), "lam")
