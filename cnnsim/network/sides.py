"""Sides: a fixed boundary with a value for each side of the grid, as a bias of the cells near it."""

from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from cnnsim.network.boundary import BOUNDARY_FORMS, Boundary, correlate, fixed, parse_boundary
from cnnsim.network.layers import AnyTemplate
from cnnsim.network.template import Template
from cnnsim.support import Array, InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number

NO_CELLS = fixed(0)
"""The boundary of a network whose virtual cells are in its bias."""

RUN_BOUNDARY_FORMS = f"{BOUNDARY_FORMS}, or sides:TOP,RIGHT,BOTTOM,LEFT"
"""Forms of a boundary of one run on the command line."""


@spelled_class
@dataclass(frozen=True)
class Sides:
    """A fixed boundary by side: the output and the input of the virtual cells above, right, below and left.

    The corners belong to the top and the bottom. Fixed virtual cells add a constant to each drive,
    bias(i, j) = sum over the taps (k, l) that leave the grid of (A(k, l) + B(k, l)) * value of that side, so the
    network runs with this bias and a boundary of 0.

    Raises:
        InputError: a value that is not a number in [-1, 1].
    """

    top: float
    right: float
    bottom: float
    left: float

    def __post_init__(self) -> None:
        for name, value in zip(("top", "right", "bottom", "left"), astuple(self), strict=True):
            if not is_number(value) or not abs(float(value)) <= 1:
                raise InputError(f"boundary value of the {name} is {shown(value)}; a number from -1 to 1 wanted")

    def bias(self, template: AnyTemplate, shape: tuple[int, ...]) -> Array:
        """Return the bias (rows, cols) of the virtual cells.

        Raises:
            InputError: a template with layers or terms, whose virtual cells do not add a constant.
        """
        if not isinstance(template, Template) or template.terms:
            raise InputError(f"template {template.name!r} has layers or terms; one value for all sides wanted")
        rows, cols = shape[-2:]
        r = max(1, template.radius)
        around = np.zeros((rows + 2 * r, cols + 2 * r))
        around[:, :r], around[:, -r:] = self.left, self.right
        around[:r], around[-r:] = self.top, self.bottom
        taps = (*template.feedback_taps, *template.control_taps)
        return correlate(around, taps, NO_CELLS, 0.0, np.zeros_like(around))[r:-r, r:-r]


def parse_run_boundary(value: Any) -> Boundary | Sides:
    """Parse a boundary of one run: a form of `parse_boundary`, or ``"sides:TOP,RIGHT,BOTTOM,LEFT"``.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, Sides):
        return value
    if not (isinstance(value, str) and value.startswith("sides:")):
        return parse_boundary(value)
    try:
        top, right, bottom, left = (float(part) for part in value.removeprefix("sides:").split(","))
    except ValueError as error:
        raise InputError(f"boundary {shown(value)}; 'sides:TOP,RIGHT,BOTTOM,LEFT' with four numbers wanted") from error
    return Sides(top, right, bottom, left)
