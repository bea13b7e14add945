"""The protocol of a backend, which runs whole transients, and of the steppers of its time loop."""

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
"""A plane in the form of its backend. A LAM plane holds real numbers, an LLM plane black and white. Grids are
(rows, cols), or (n, rows, cols) for n independent grids."""

Memory = Literal["lam", "llm"]


class Outcome(NamedTuple):
    """The end of a transient: the state plane, the time [time constants], whether it settled, the largest |dx/dt|.

    ``rate`` is NaN where it is not computed (a fixed duration, a closed form at a finite time). ``saturated``: the last
    check found that no output can change any more.
    """

    x: Plane
    t: float
    settled: bool
    rate: float
    saturated: bool = False


Area = tuple[tuple[int, int], tuple[int, int]]
"""Rows and columns [first, after) of a grid."""


def check_fixed_step(plan: Plan) -> None:
    """Refuse the adaptive scheme, which only the reference backend has.

    Raises:
        InputError: the plan has the adaptive scheme.
    """
    if plan.method == "adaptive" or (plan.method == "general" and plan.cell != "discrete-time" and plan.scheme is None):
        raise InputError(
            "the adaptive scheme runs on the reference backend; choose --backend reference or a fixed-step scheme"
        )


class Backend(Protocol):
    """Operations of a backend."""

    name: str
    dtype: np.dtype[Any]
    fuses: bool = False
    """Whether its compiled routines have steps, cellwise operations, and registers of batches."""

    def load(self, values: Array, memory: Memory, *, copy: bool = True) -> Plane:
        """Return an array as a plane; values above 0 are black in an LLM.

        ``copy=False``: the caller does not change the array.
        """

    def constant(self, value: float | Array, shape: tuple[int, ...], memory: Memory) -> Plane:
        """Return a plane of one number, or of one for each grid of a batch."""
        return self.load(np.full(shape, value), memory)

    def read(self, plane: Plane, *, copy: bool = True) -> Array:
        """Return a plane as an array: floats of a LAM, booleans (True is black) of an LLM.

        ``copy=False``: the caller needs the plane no longer, so the array may be the plane itself.
        """

    def hand_out(self, name: str, plane: Plane) -> Any:
        """Return a plane as a program's result ``name``: an array, or a reader of it where planes are not in memory."""
        return self.read(plane)

    def convert(self, plane: Plane, memory: Memory) -> Plane:
        """Return the plane for the other memory: black is +1, white -1; a value above 0 is black."""

    def transient(
        self, plan: Plan, x: Plane, u: Plane | None, bias: Plane | None = None, mask: Plane | None = None
    ) -> Outcome:
        """Run a transient from the state ``x``. Planes are LAM, ``mask`` is LLM: its black cells keep their state."""

    def output(self, x: Plane, f: Characteristic = CLIP) -> Plane:
        """Return y = f(x)."""

    def cellwise(self, operation: Cellwise, planes: Sequence[Plane], parameters: Sequence[float]) -> tuple[Plane, ...]:
        """Apply a per-cell operation to LAM planes."""

    def logic(self, function: int, p: Plane, q: Plane) -> Plane:
        """Apply one of the 16 two-input functions (see `cnnsim.operations.logic`) to LLM planes."""

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Plane) -> Plane:
        """Apply an AND or OR of neighbours (a `BitRule`) to an LLM plane; fixed virtual cells hold u > 0."""

    def count(self, plane: Plane) -> int | Integers:
        """Count the black cells of an LLM plane, the global wire: a number, or (n,) numbers for n grids."""

    def prepared(self, routine: Routine) -> Callable[[Stores], Stores | None] | None:
        """Return the compiled routine, or None where compiling saves nothing.

        It takes the given planes and registers and returns the results; None where the steps have to be run one by one
        to find the error.
        """
        return None


class Check(NamedTuple):
    """Result of a check of a state before its next step.

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
    """Check the cells of an area that are not masked; ``planes`` are state, input, bias and mask.

    Not for discrete time, where the outputs of two steps are compared.
    """
    x, u, bias, mask = planes
    held = np.ones(x.shape, bool)
    (r0, r1), (c0, c1) = area
    held[..., r0:r1, c0:c1] = False if mask is None else backend.read(mask)[..., r0:r1, c0:c1]
    now = replace(plan, duration="settled", limit=0.0)
    found = backend.transient(now, x, u, bias, backend.load(held, "llm"))
    return Check(found.rate, found.saturated)


class Stepper(Protocol):
    """Steps of one transient on a backend; the time loop (`driver`) decides when to take and check them.

    ``work`` estimates the weighted neighbours summed in one step; steps are best taken in multiples of ``together``.
    ``few``: the most steps of the first slice: on a busy machine each step can wait milliseconds for its threads.
    """

    work: float
    together: int = 1
    few: int = 256

    def advance(self, step: int, count: int) -> None:
        """Take ``count`` steps; ``step`` is the number of the first."""

    def wait(self) -> None:
        """Wait until all steps are done; nothing to do where `advance` does."""
        return

    def finish(self) -> Plane:
        """Return the plane of the state."""


class CheckedStepper(Stepper, Protocol):
    """Steps that `driver.run` checks one time constant after the other."""

    def start_span(self, step: int) -> None:
        """Use the input and bias of this step from now on; does nothing if both are constant."""
        return

    def check_settled(self, step: int, *, last: bool) -> Check:
        """Check the state before this step; if it has not settled, only the ``last`` check must give the full rate."""


class SettlingStepper(Stepper, Protocol):
    """Steps with checks among them, for `driver.run_with_checks`; ``checks``: the most checks in one call."""

    checks: int

    def settle(self, step: int, count: int, *, last: bool) -> tuple[int, Check]:
        """Take ``count`` steps with their checks, or those until the network has settled.

        Return the steps taken and the check at their end, or the last one before it. ``last``: check the end too.
        """


def parse_dtype(dtype: DTypeLike) -> np.dtype[Any]:
    """Return the dtype of a name.

    Raises:
        InputError: there is no such dtype.
    """
    try:
        return np.dtype(dtype)
    except TypeError as error:
        raise InputError(f"dtype {dtype!r}; float32 or float64 wanted") from error


class NotFiniteError(InputError):
    """A state is NaN or infinite."""


def check_finite(x: Array, t: float) -> None:
    """Raise NotFiniteError if a state is not finite; the message names the first such cell."""
    if not np.isfinite(x).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(x))[0])
        raise NotFiniteError(f"the state is {x[where]} in cell {where} at t = {t:g}; planes must hold finite numbers")
