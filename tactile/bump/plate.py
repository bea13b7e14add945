"""Rigid plate on the bump as a constraint: prescribed displacements and the resulting force."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.bump.body import Body, solve
from tactile.bump.shape import Shape

Push = Literal["press", "shift"]
"""Motion along z, into the body, or along x; the plate does not tilt."""


@dataclass(frozen=True)
class Constraint:
    """The prescribed unknowns of a body: those at ``fixed`` are the plate's displacement times ``rigid``."""

    fixed: Integers
    rigid: Floats

    def state(self, displacement: float) -> Floats:
        """Return the values at ``fixed`` for a displacement [m] of the plate."""
        return displacement * self.rigid[self.fixed]

    def force(self, out_of_balance: Floats) -> float:
        """Return the plate's force along its motion [N], from the virtual work of a unit displacement."""
        return float(self.rigid @ out_of_balance)


def plate_constraint(body: Body, shape: Shape, push: Push, contact: float | None = None) -> Constraint:
    """Fix the bottom, free the sides, and stick the top to the plate up to ``contact`` [m], by default the shape's."""
    reach = shape.contact if contact is None else contact
    x, z = body.place
    near = 1e-9 * shape.radius
    moving = body.component >= 0
    arc = shape.curved(np.stack([np.abs(x), z], axis=-1))
    top = moving & arc & (np.abs(x) <= reach + near)
    fixed = top | (moving & (z >= shape.thickness - near))
    for component in body.kinematics.axis:
        fixed |= (body.component == component) & (np.abs(x) <= near)
    if body.kinematics.axis and push == "shift":
        fixed |= (body.component == -1) & (np.abs(x) <= near)  # a pressure that goes with cos(theta) is 0 there too
    unit = body.kinematics.press if push == "press" else body.kinematics.shift
    assert unit is not None
    rigid = np.where(top, np.array([*unit, 0.0])[body.component], 0.0)
    return Constraint(np.flatnonzero(fixed), rigid)


def respond(body: Body, constraint: Constraint, rest: tuple[Floats, Floats] | None = None) -> Floats:
    """Return the small-strain state per metre of the plate's motion, about ``rest``, by default undeformed."""
    matrix = body.at_rest if rest is None else body.stiffness(*rest)
    return solve(matrix, np.zeros(body.size), constraint.fixed, constraint.state(1.0))


def stiffness(body: Body, constraint: Constraint, state: Floats) -> float:
    """Return force over displacement [N/m] of a small-strain response."""
    return constraint.force(body.at_rest @ state)
