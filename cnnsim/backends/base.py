"""The protocol of a backend: the whole transient is its business, so the time loop never crosses this line."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import DTypeLike

from cnnsim.network import Boundary, Characteristic
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.routine import Routine, Stores
from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.support import Array, InputError, Integers

Plane = Any
"""Opaque to everybody but its backend. A LAM plane holds real numbers, an LLM plane black and white. Grids are
(rows, cols), or (n, rows, cols) for n grids that know nothing of each other."""

Memory = Literal["lam", "llm"]


class Outcome(NamedTuple):
    """The end of a transient: the state plane, the time [time constants], whether it settled, the largest |dx/dt|.

    ``rate`` is NaN where it was not asked for (a fixed duration, a closed form at a finite time). ``saturated``: the
    check saw that no output can change any more, so that nobody need read the plane to know it.
    """

    x: Plane
    t: float
    settled: bool
    rate: float
    saturated: bool = False


Area = tuple[tuple[int, int], tuple[int, int]]
"""Rows and columns [first, after) of a grid."""


def check_fixed_step(plan: Plan) -> None:
    """Refuse the adaptive scheme, which is the reference backend's alone.

    Raises:
        InputError: the plan has it.
    """
    if plan.method == "adaptive" or (plan.method == "general" and plan.cell != "discrete-time" and plan.scheme is None):
        raise InputError(
            "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
        )


class Backend(Protocol):
    """What the machine asks of a place that computes."""

    name: str
    dtype: np.dtype[Any]

    def load(self, values: Array, memory: Memory, *, copy: bool = True) -> Plane:
        """Bring an array in; into an LLM everything above 0 is black. ``copy=False``: it stays as it is meanwhile."""

    def constant(self, value: float | Array, shape: tuple[int, ...], memory: Memory) -> Plane:
        """Make a plane of one number, or of one for each grid of a batch."""
        return self.load(np.full(shape, value), memory)

    def read(self, plane: Plane, *, copy: bool = True) -> Array:
        """Bring a plane out as an array: floats from a LAM, booleans (True is black) from an LLM.

        ``copy=False``: the plane is the end of a transient and in use no more, so the array may be the plane itself.
        """

    def hand_out(self, name: str, plane: Plane) -> Any:
        """Give a plane as a program's result ``name``: an array, or where planes are not in memory what reads it."""
        return self.read(plane)

    def convert(self, plane: Plane, memory: Memory) -> Plane:
        """Give the plane for the other memory: black is +1, white -1; a value above 0 is black."""

    def transient(
        self, plan: Plan, x: Plane, u: Plane | None, bias: Plane | None = None, mask: Plane | None = None
    ) -> Outcome:
        """Run a transient from the state ``x``; LAM planes, but ``mask`` (LLM): black cells keep their state."""

    def output(self, x: Plane, f: Characteristic = CLIP) -> Plane:
        """Give y = f(x)."""

    def cellwise(self, operation: Cellwise, planes: Sequence[Plane], parameters: Sequence[float]) -> tuple[Plane, ...]:
        """Apply a per-cell operation to LAM planes."""

    def logic(self, function: int, p: Plane, q: Plane) -> Plane:
        """Apply one of the 16 two-input functions (see `cnnsim.operations.logic`) to LLM planes."""

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Plane) -> Plane:
        """Apply an AND or OR of neighbours (a `BitRule`) to an LLM plane; fixed virtual cells hold u > 0."""

    def count(self, plane: Plane) -> int | Integers:
        """Count the black cells of an LLM plane, the global wire: a number, or (n,) numbers for n grids."""

    def prepared(self, routine: Routine) -> Callable[[Stores], Stores | None] | None:
        """Give what does a routine at one go; None where that saves nothing, so that its steps are done one by one.

        It takes the planes and registers that are given and returns the results, or None where step by step is to tell
        why there are none.
        """
        return None


class Check(NamedTuple):
    """What a check of the step that would come found.

    ``rate``: the largest |dx/dt| of the free cells (in discrete time, the largest change to come); ``saturated``:
    whether no output can change any more (see `Plan`); ``repeats``: the state of two steps ago would come again.
    """

    rate: float
    saturated: bool = False
    repeats: bool = False

    @property
    def settled(self) -> bool:
        """Whether the network has settled (see `Plan`)."""
        return self.saturated or self.rate <= SETTLED_RATE


def check_area(
    backend: Backend, plan: Plan, planes: tuple[Plane, Plane | None, Plane | None, Plane | None], area: Area
) -> Check:
    """Check the cells of an area that the mask leaves free; ``planes`` are state, input, bias and mask.

    Not of discrete time, where the outputs of two steps are compared.
    """
    x, u, bias, mask = planes
    held = np.ones(x.shape, bool)
    (r0, r1), (c0, c1) = area
    held[..., r0:r1, c0:c1] = False if mask is None else backend.read(mask)[..., r0:r1, c0:c1]
    now = replace(plan, duration="settled", limit=0.0)
    found = backend.transient(now, x, u, bias, backend.load(held, "llm"))
    return Check(found.rate, found.saturated)


class Stepper(Protocol):
    """Steps of one transient on a backend; `driver.run` says when to take and to check them.

    ``work``: sums of a weighted neighbour in one step, a guess; ``together``: steps that are best taken at a stretch.
    """

    work: float
    together: int = 1

    def start_span(self, step: int) -> None:
        """Take input and bias as they are from this step on; nothing to do where both stand still for ever."""
        return

    def check_settled(self, step: int, *, last: bool) -> Check:
        """Check the state before this step; only the ``last`` check must measure the rate of a network that moves."""

    def advance(self, step: int, count: int) -> None:
        """Take ``count`` steps, the first of them number ``step``."""

    def wait(self) -> None:
        """Wait until all steps are done; nothing to do where `advance` does."""
        return

    def finish(self) -> Plane:
        """Return the plane of the state."""


def parse_dtype(dtype: DTypeLike) -> np.dtype[Any]:
    """Return a dtype by its name.

    Raises:
        InputError: there is none of that name.
    """
    try:
        return np.dtype(dtype)
    except TypeError as error:
        raise InputError(f"dtype {dtype!r}; float32 or float64 wanted") from error


class NotFiniteError(InputError):
    """A state came out as NaN or infinite."""


def check_finite(x: Array, t: float) -> None:
    """Raise NotFiniteError if a state is not finite; the message names the first such cell."""
    if not np.isfinite(x).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(x))[0])
        raise NotFiniteError(f"the state is {x[where]} in cell {where} at t = {t:g}; planes must hold finite numbers")
