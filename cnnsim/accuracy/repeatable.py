"""A transient that can be run again, by another plan or on a part of its grid, and what came of it to an accuracy."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from cnnsim.backends.base import Backend, Outcome
from cnnsim.network import Frames
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags


class Start(Protocol):
    """Runs a transient on a backend by a plan, from its own state or another."""

    def __call__(self, where: Backend, plan: Plan, state: Array | None = None, /) -> Outcome:
        """Return where it ends."""


WINDOW = 20
"""Cells on a side of a window of the sample."""
LEAST_CELLS = 32_768
"""Of a transient of which a sample is taken: on smaller grids a run costs little more than its call."""
_MOST_WINDOWS = 6
_CELLS_A_WINDOW = 8_192
"""A window for so many cells, so that all runs of the sample cost a part of one run of the grid."""


@dataclass(frozen=True)
class Reached:
    """The end of a transient to an accuracy: the state, its error by the run's own estimate, the cells not vouched for.

    ``plan`` is that of the run that counts; ``how`` says in words what was done and why.
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
class Repeatable:
    """A transient that can be run again: its ``plan``, ``start`` on a backend by another plan, and its planes.

    ``planes`` are state, input, bias and mask as arrays (or None, or sequences).
    """

    plan: Plan
    start: Start
    planes: tuple[Any, Any, Any, Any]

    @property
    def timed(self) -> bool:
        """Whether delays or sequences fix which steps there may be."""
        from cnnsim.planning.general import delays_of  # no cost, but only general plans ask

        network = self.plan.network
        return network is not None and (
            bool(delays_of(network)) or any(isinstance(plane, Frames) for plane in self.planes)
        )

    def free(self, cells: Flags) -> Flags:
        """Return those of some cells that are not held: nothing decides about a state that is kept, be it 0."""
        held = self.planes[3]
        return cells if held is None else cells & ~held

    def once(self, where: Backend, how: str) -> Reached:
        """Run it by its own plan, which is exact."""
        outcome = self.start(where, self.plan)
        x = where.read(outcome.x)
        nowhere = np.zeros(x.shape, bool)
        return Reached(x, outcome.t, outcome.settled, outcome.rate, 0.0, nowhere, self.plan, how)

    def pushed(self, where: Backend, roundings: float, number: int = 0) -> Array:
        """Return the state with each free cell pushed by so many roundings of a backend's numbers, this way or that."""
        state, held = self.planes[0], self.planes[3]
        signs = _signs(state.shape) if number % 2 else _signs(state.shape)[..., ::-1]
        moved: Array = np.abs(state)
        np.maximum(moved, 1.0, out=moved)
        moved *= signs
        moved *= roundings * float(np.finfo(where.dtype).eps)
        if held is not None:
            moved[held] = 0
        moved += state
        return moved.clip(-1, 1) if self.plan.cell == "full-range" else moved

    def sample(self) -> "Repeatable | None":
        """Return the transient on some windows of its grid, as grids of their own; None where that saves nothing.

        Half of the windows are those in which state and input vary most, the others lie anywhere.
        """
        rows, cols = self.plan.shape
        state = self.planes[0]
        if state.size < LEAST_CELLS or min(rows, cols) < 2 * WINDOW or self._placed:
            return None
        number = int(np.clip(state.size // _CELLS_A_WINDOW, 1, _MOST_WINDOWS))
        places = self._places(number)
        plan = replace(self.plan, shape=(WINDOW, WINDOW))
        planes: Any = tuple(_cut(plane, self.planes[0].shape, places) for plane in self.planes)

        def start(where: Backend, again: Plan, state: Array | None = None, /) -> Outcome:
            x, u, bias = (_loaded(where, p, "lam") for p in (planes[0] if state is None else state, *planes[1:3]))
            return where.transient(again, x, u, bias, _loaded(where, planes[3], "llm"))

        return Repeatable(plan, start, planes)

    @property
    def _placed(self) -> bool:
        """Whether weights belong to places of the grid, or layers make grids of windows ambiguous."""
        network = self.plan.network
        layers = (self.plan.template,) if network is None else network.layers
        return len(layers) > 1 or any(term.weights.ndim == 4 for layer in layers for term in layer.terms)

    def _places(self, number: int) -> list[tuple[int, int, int]]:
        """Return (grid, row, column) of the windows' corners."""
        rows, cols = self.plan.shape
        state = self.planes[0].reshape(-1, rows, cols)
        u = self.planes[1].planes[0] if isinstance(self.planes[1], Frames) else self.planes[1]
        rng = np.random.default_rng(0)
        draw = rng.integers(0, (len(state), rows - WINDOW + 1, cols - WINDOW + 1), (8 * number, 3))
        places: list[tuple[int, int, int]] = [tuple(int(i) for i in place) for place in draw]  # type: ignore[misc]  # three

        def varies(place: tuple[int, int, int]) -> float:
            n, i, j = place
            windows = [state[n, i : i + WINDOW, j : j + WINDOW]]
            if u is not None:
                windows.append(u.reshape(-1, rows, cols)[n, i : i + WINDOW, j : j + WINDOW])
            return sum(float(np.std(window)) for window in windows)

        lively = sorted(places[number // 2 :], key=varies, reverse=True)
        return places[: number // 2] + lively[: number - number // 2]


def _cut(plane: Any, shape: tuple[int, ...], places: list[tuple[int, int, int]]) -> Any:
    if plane is None:
        return None
    if isinstance(plane, Frames):
        return plane.map(lambda one: _cut(one, shape, places))
    grids = np.broadcast_to(plane, shape).reshape(-1, *shape[-2:])
    return np.stack([grids[n, i : i + WINDOW, j : j + WINDOW] for n, i, j in places])


def _loaded(where: Backend, plane: Any, memory: Any) -> Any:
    if isinstance(plane, Frames):
        return plane.map(lambda one: where.load(one, memory))
    return None if plane is None else where.load(plane, memory)


@lru_cache(maxsize=2)
def _signs(shape: tuple[int, ...]) -> Array:
    """Return +1 and -1, at random; one byte each."""
    return 2 * np.random.default_rng(0).integers(0, 2, shape, np.int8) - np.int8(1)


def largest(x: Array) -> float:
    """Return the largest |x|, 0 of nothing, infinite where it is no number."""
    found = float(np.abs(x).max(initial=0.0))
    return found if math.isfinite(found) else math.inf
