"""Frames: an input or a bias that is piecewise constant in time, given by a sequence of planes."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_number, shape_of

T = TypeVar("T")


@dataclass(frozen=True, eq=False, repr=False)
class Frames(Generic[T]):
    """A sequence of planes: plane k is valid for k period <= t < (k + 1) period, the last one until the end.

    Before t = 0 the first one is valid. ``period`` is in time constants.

    Raises:
        InputError: no plane, planes of unequal shape, or a period that is not positive.
    """

    planes: tuple[T, ...]
    period: float

    @spelled()
    def __init__(self, planes: Iterable[T], period: float) -> None:
        if isinstance(planes, str | Mapping | Frames) or not isinstance(planes, Iterable):
            raise InputError(f"a sequence of planes {shown(planes)}; a list of them wanted")
        object.__setattr__(self, "planes", tuple(planes))
        object.__setattr__(self, "period", period)
        if not self.planes:
            raise InputError("a sequence of planes without a plane; one or more wanted")
        if not is_number(period) or not 0 < period < np.inf:
            raise InputError(f"a plane every {period!r}; a positive number of time constants wanted")
        _check_shapes(self.planes)

    def __repr__(self) -> str:
        """Return the number and the size of the planes, without their values."""
        plane: Any = self.planes[0]  # an array, or a plane of a backend, which has no shape
        shape = np.shape(plane)
        size = f" of {' x '.join(map(str, shape))}" if shape else ""
        count = f"{len(self.planes)} plane{'s' if len(self.planes) > 1 else ''}{size}"
        return f"Frames({count}, a new one every {self.period:g} time constants)"

    def map(self, function: Callable[[T], Any]) -> "Frames[Any]":
        """Return the sequence of the results of a function on each plane."""
        return Frames([function(plane) for plane in self.planes], self.period)


def _check_shapes(planes: tuple[Any, ...]) -> None:
    """Check that the shapes agree: a number is for all cells, a plane (rows, cols) for all grids and layers."""
    shapes = [shape_of(f"plane {number}", plane) for number, plane in enumerate(planes)]
    widest = max(range(len(shapes)), key=lambda number: len(shapes[number]))
    for number, shape in enumerate(shapes):
        if shape and shapes[widest][-len(shape) :] != shape:
            first, second = sorted((number, widest))
            raise InputError(
                f"a sequence of planes: plane {first} has shape {shapes[first]}, plane {second} {shapes[second]}; one "
                "shape wanted"
            )


def at_step(value: Any, number: int, step: float) -> Any:
    """Return the plane in step ``number`` of length ``step``; a value that is no sequence is returned as it is."""
    if not isinstance(value, Frames):
        return value
    return value.planes[min(max(0, number) // round(value.period / step), len(value.planes) - 1)]


def spans(steps: int, step: float, delays: Sequence[float], *inputs: Any) -> Iterator[tuple[int, int]]:
    """Yield (first step, number of steps) of the spans in which all inputs, delayed ones too, are constant."""
    edges = {0, steps}
    for value in inputs:
        if isinstance(value, Frames):
            period = round(value.period / step)
            for delay in {0, *(round(delay / step) for delay in delays)}:
                edges |= {k * period + delay for k in range(1, len(value.planes))}
    inside = sorted(edge for edge in edges if edge <= steps)
    for first, after in pairwise(inside):
        yield first, after - first
