"""Boundary conditions: the values of the virtual cells around the grid."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np

from cnnsim.network.weights import Tap, reach
from cnnsim.support import Array, InputError, Integers
from cnnsim.support.errors import did_you_mean, not_known, shown
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number

BoundaryKind = Literal["fixed", "zero-flux", "periodic", "reflecting"]


@spelled_class
@dataclass(frozen=True)
class Boundary:
    """A boundary condition.

    ``fixed``: virtual cells have the constant output ``y``, of modulus <= 1 as outputs are, and the constant input
    ``u``; ``zero-flux``: they repeat the nearest real cell; ``periodic``: the grid is a torus; ``reflecting``: they
    mirror the real cells about the outermost ones, so that cell -k has the values of cell k. Coupled templates have
    reflecting boundaries on the reference backend only.

    Raises:
        InputError: an unknown kind, an output that is not a number in [-1, 1], an input that is no finite number.
    """

    kind: BoundaryKind
    y: float = 0.0
    u: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in get_args(BoundaryKind):
            raise not_known("boundary", self.kind, get_args(BoundaryKind))
        for name, most in (("y", 1.0), ("u", sys.float_info.max)):
            value = getattr(self, name)
            if not is_number(value) or not abs(float(value)) <= most:
                wanted = (
                    "a number from -1 to 1 wanted; 'fixed:x,u' takes inputs u beyond" if most == 1 else "finite wanted"
                )
                raise InputError(f"fixed boundary value of {name} is {shown(value)}; {wanted}")
            object.__setattr__(self, name, float(value))

    @property
    def constants(self) -> tuple[tuple[float, float], ...]:
        """The constant (y, u) of virtual cells; empty if they repeat real cells."""
        return ((self.y, self.u),) if self.kind == "fixed" else ()

    def __str__(self) -> str:
        if self.kind != "fixed":
            return self.kind
        return f"fixed {self.y:g}" if self.y == self.u else f"fixed x = {self.y:g}, u = {self.u:g}"


def fixed(x: float, u: float | None = None) -> Boundary:
    """Return a fixed boundary: virtual cells have the output ``x`` and the input ``u`` (``x`` if None)."""
    return Boundary("fixed", x, x if u is None else u)


ZERO_FLUX = Boundary("zero-flux")
PERIODIC = Boundary("periodic")

BOUNDARY_FORMS = "zero-flux, periodic, reflecting, fixed:v or fixed:x,u"
"""Forms of a boundary on the command line."""


def parse_boundary(value: Any) -> Boundary:
    """Parse a boundary of a file or the command line.

    ``"zero-flux"``, ``"periodic"``, ``"reflecting"``, ``{"fixed": v}``,
    ``{"fixed": {"x": v, "u": w}}``, ``"fixed:v"``, ``"fixed:v,w"``.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, Boundary):
        return value
    if isinstance(value, str) and value.startswith("fixed:"):
        try:
            return fixed(*(float(part) for part in value.removeprefix("fixed:").split(",", 1)))
        except ValueError as error:
            raise InputError(
                f"boundary {shown(value)}; 'fixed:v' or 'fixed:x,u' with numbers x from -1 to 1 wanted"
            ) from error
    if isinstance(value, str) and value in get_args(BoundaryKind) and value != "fixed":
        return Boundary(value)  # type: ignore[arg-type]  # just checked
    if isinstance(value, dict) and set(value) == {"fixed"}:
        inner = value["fixed"]
        if not isinstance(inner, dict):
            return fixed(inner)
        if set(inner) == {"x", "u"}:
            return fixed(inner["x"], inner["u"])
    raise InputError(
        f"boundary {shown(value)}; wanted 'zero-flux', 'periodic', 'reflecting', 'fixed:v' or, in a file, "
        "{ fixed = v } or { fixed = { x = v, u = w } }"
        f"{did_you_mean(value, ('zero-flux', 'periodic', 'reflecting'))}"
    )


def boundary_value(boundary: Boundary) -> Any:
    """Return the value of a boundary in a file, the reverse of `parse_boundary`."""
    if boundary.kind != "fixed":
        return boundary.kind
    return {"fixed": boundary.y if boundary.y == boundary.u else {"x": boundary.y, "u": boundary.u}}


def virtual_index(cells: int, radius: int, boundary: Boundary) -> Integers:
    """Return the real cell of each position -radius .. cells + radius - 1 of an axis; -1 for a constant one.

    The grid may be smaller than the radius.
    """
    position = np.arange(-radius, cells + radius)
    if boundary.kind == "periodic":
        return position % cells
    if boundary.kind == "zero-flux":
        return position.clip(0, cells - 1)
    if boundary.kind == "reflecting":
        turned = position % max(1, 2 * cells - 2)
        return np.minimum(turned, 2 * cells - 2 - turned)
    return np.where((position >= 0) & (position < cells), position, -1)


def pad(plane: Array, radius: int, boundary: Boundary, constant: float) -> Array:
    """Return planes (..., rows, cols) with ``radius`` virtual cells on each side, ``constant`` for a fixed one."""
    if boundary.kind != "fixed":
        return plane[_around(plane.shape[-2], plane.shape[-1], radius, boundary)]
    rows, cols = plane.shape[-2:]
    padded = np.full((*plane.shape[:-2], rows + 2 * radius, cols + 2 * radius), constant, plane.dtype)
    padded[..., radius : radius + rows, radius : radius + cols] = plane
    return padded


@lru_cache(maxsize=64)
def _around(rows: int, cols: int, radius: int, boundary: Boundary) -> tuple[Any, ...]:
    """Return the index of the real cells of a padded plane, for a boundary that repeats real cells."""
    return ..., virtual_index(rows, radius, boundary)[:, None], virtual_index(cols, radius, boundary)


def correlate(plane: Array, taps: Sequence[Tap], boundary: Boundary, constant: float, start: Array) -> Array:
    """Return start + sum over the taps of weight * plane(row + k, col + l), added in the order of the taps."""
    total, r = start.copy(), reach((k, l) for k, l, _ in taps)
    around = pad(plane, r, boundary, constant)
    rows, cols = plane.shape[-2:]
    for k, l, weight in taps:
        total += weight * around[..., r + k : r + k + rows, r + l : r + l + cols]
    return total
