"""A template step run to an accuracy: the planes read, the transient repeated until its error is small enough."""

import numpy as np

from cnnsim.accuracy.repeatable import Repeatable, largest
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends.base import Backend, Outcome, Plane
from cnnsim.ended import reached
from cnnsim.planning.plan import Plan
from cnnsim.support import Array
from cnnsim.support.notices import Notices


def to_accuracy(backend: Backend, plan: Plan, wanted: Wanted, *planes: Plane | None) -> Plane:
    """Run a transient of state, input, bias and mask to an accuracy, in float64 where it must be; return its state.

    It goes back into memories in the machine's own numbers; where those keep less than the accuracy, that is told.
    """
    read = [None if plane is None else backend.read(plane) for plane in planes]
    x, u, bias = (None if plane is None else plane.astype(np.float64) for plane in read[:3])

    def start(where: Backend, again: Plan, pushed: Array | None = None, /) -> Outcome:
        given = (x if pushed is None else pushed, u, bias)
        state, shown, added = (None if plane is None else where.load(plane, "lam") for plane in given)
        return where.transient(again, state, shown, added, None if read[3] is None else where.load(read[3], "llm"))

    found = reached(Repeatable(plan, start, (x, u, bias, read[3])), backend, wanted)
    kept = 0.5 * float(np.finfo(backend.dtype).eps) * max(1.0, largest(found.x))
    if not wanted.signs and wanted.error < kept and backend.dtype != "float64":
        cure = "the reference backend, or dtype float64, wanted for more"
        Notices.once(
            f"accuracy {wanted}: planes in memories of {backend.dtype} are rounded by up to {kept:.2g}; {cure}"
        )
    return backend.load(found.x.astype(backend.dtype), "lam")
