"""The initial value problem of a transient, which can be solved repeatedly, and its solution to an accuracy."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cnnsim.backends.base import Backend, Outcome
from cnnsim.network import Frames
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags


class Start(Protocol):
    """Runs a transient on a backend by a plan, from its own initial state or from ``state``."""

    def __call__(self, where: Backend, plan: Plan, state: Array | None = None, /) -> Outcome:
        """Return the outcome."""


@dataclass(frozen=True)
class Solution:
    """The end of a transient to an accuracy: the state, its estimated error, and the undecided cells.

    ``plan`` is the plan of the last run; ``how`` is a text about how the solution was found.
    """

    x: Array
    t: float
    settled: bool
    rate: float
    error: float
    undecided: Flags
    plan: Plan
    how: str


@dataclass(frozen=True)
class TransientProblem:
    """A transient that can be run several times: its ``plan``, ``start`` on a backend by any plan, and its planes.

    ``planes`` are state, input, bias and mask as arrays (or None, or sequences).
    """

    plan: Plan
    start: Start
    planes: tuple[Any, Any, Any, Any]

    @property
    def timed(self) -> bool:
        """Whether delays or sequences restrict the steps."""
        network = self.plan.network
        return network is not None and (
            bool(delays_of(network)) or any(isinstance(plane, Frames) for plane in self.planes)
        )

    def free(self, cells: Flags) -> Flags:
        """Return the given cells without the masked ones, whose state is kept and never undecided."""
        mask = self.planes[3]
        return cells if mask is None else cells & ~mask

    def once(self, where: Backend, how: str) -> Solution:
        """Run it by its own plan, which is exact."""
        outcome = self.start(where, self.plan)
        x = where.read(outcome.x)
        none = np.zeros(x.shape, bool)
        return Solution(x, outcome.t, outcome.settled, outcome.rate, 0.0, none, self.plan, how)

    def perturbed(self, where: Backend, roundings: float, seed: int = 0) -> Array:
        """Return the state with each free cell changed by up to ``roundings`` units of a backend's rounding.

        The changes differ, so that they leave any symmetry of the state.
        """
        state, mask = self.planes[0], self.planes[3]
        least = min(1.0, size_of_drives(self.plan, *self.planes[:3]))
        size = roundings * float(np.finfo(where.dtype).eps) * np.maximum(np.abs(state), least)
        size *= changes(state.shape, seed)
        x: Array = state + (size if mask is None else np.where(mask, 0, size))
        return x.clip(-1, 1) if self.plan.cell == "full-range" else x


def changes(shape: tuple[int, ...], seed: int = 0) -> Array:
    """Return random numbers of a modulus from 1/2 to 1."""
    rng = np.random.default_rng(seed)
    signs = 2 * rng.integers(0, 2, shape, np.int8) - 1
    return signs * rng.uniform(0.5, 1.0, shape)


def size_of_drives(plan: Plan, x: Array, u: Any, bias: Any) -> float:
    """Return an upper bound of the sums of products in a state, of which a drive may be a small difference."""
    if any(isinstance(plane, Frames) for plane in (u, bias)):
        return math.inf
    of_x, of_u, of_bias = (0.0 if plane is None else largest(plane) for plane in (x, u, bias))
    size = of_x + of_bias
    for layer in (plan.template,) if plan.network is None else plan.network.layers:
        size += abs(layer.z) + float(np.abs(layer.A).sum()) * of_x + float(np.abs(layer.B).sum()) * of_u
        for term in layer.terms:
            size += term.bound * (max(of_x, of_u) if term.table is None and term.times is None else 1.0)
    return size


def largest(x: Array) -> float:
    """Return the largest |x|, 0 of nothing, infinite where it is no number."""
    found = float(np.abs(x).max(initial=0.0))
    return found if math.isfinite(found) else math.inf
