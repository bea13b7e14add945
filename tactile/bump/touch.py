"""Rigid flat plate lowered on the bump: touched nodes stick, and the contact grows."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Flags, Floats, InputError, Integers
from tactile.bump.body import Body, solve
from tactile.bump.finite import balance
from tactile.bump.plate import plate_constraint
from tactile.bump.shape import Shape

PULL = 1e-6
"""Pull that releases a node, as a share of the largest nodal force: above rounding."""


@dataclass(frozen=True)
class Touch:
    """The bump under the plate: ``indentation`` [m], ``contact``: half the width that sticks, on the undeformed bump
    [m], ``force`` [N] (per metre of thickness in the plane), and the body's ``state``."""

    indentation: float
    contact: float
    force: float
    state: Floats


def lower(body: Body, shape: Shape, indentations: Iterable[float], finite: bool) -> Iterator[Touch]:
    """Lower a rigid flat plate step by step on the top of a body.

    Nodes of the arc that reach the plate stick where they arrive (infinite friction); at the edge they come off where
    the plate would pull: the contact grows and shrinks by whole nodes.

    Arguments: ``indentations`` [m], growing; ``finite``: strains of any size, else the small-strain body.

    Raises:
        InputError: indentations that do not grow, or at which no balance is found.

    Source: Vasarhelyi, Fodor, Roska, sect. 5: "flat and rigid, touching the top of the bump with infinite friction".
    """
    nodes = _Nodes(body, shape)
    sticking, anchor = nodes.on_axis.copy(), np.zeros(nodes.x.size)
    linear = None if finite else body.at_rest
    state, reached = np.zeros(body.size), 0.0
    for wanted in indentations:
        if not (np.isfinite(wanted) and wanted >= reached):
            raise InputError(f"an indentation of {wanted} m after {reached} m, growing ones wanted")
        lowered = wanted - nodes.gap
        about = linear if linear is not None else body.stiffness(*body.at_points(state))
        offset = -body.forces(state) if finite else np.zeros(body.size)
        certain = False  # whether the tried state is the balance, not its linear estimate
        released, kept = np.zeros_like(sticking), np.zeros_like(sticking)
        while True:
            fixed, values = nodes.prescribed(sticking, anchor, lowered)
            if certain:
                found = balance(body, state, fixed, values)
                if found is None:
                    raise InputError(
                        f"a plate {wanted * 1e6:.4g} um down: no balance of forces beyond {reached * 1e6:.4g} um; "
                        "a smaller indentation, or smaller steps to it wanted"
                    )
                tried = found
            elif finite:
                tried = state + solve(about, offset, fixed, values - state[fixed])
            else:
                tried = solve(about, offset, fixed, values)
            over = ~sticking & (tried[nodes.down] < lowered - 1e-9 * shape.radius)
            if over.any():
                # the side displacement at which the plate met a node lies between those of both states
                before, after = state[nodes.down] - (reached - nodes.gap), tried[nodes.down] - lowered
                share = np.clip(before / np.where(over, before - after, 1), 0, 1)
                anchor[over] = (state[nodes.side] + share * (tried[nodes.side] - state[nodes.side]))[over]
                sticking |= over
                kept |= over & released  # it came off and back: the pull there is an error of the mesh
            elif finite and not certain:
                certain = True
            else:
                forces = (body.forces(tried) if linear is None else linear @ tried)[nodes.down]
                edge = nodes.outermost(sticking & ~kept)
                if edge is None or forces[edge] >= -PULL * np.abs(forces).max():
                    break
                sticking[edge], released[edge] = False, True
        state, reached = tried, wanted
        forces = body.forces(state) if linear is None else linear @ state
        yield Touch(wanted, float(nodes.x[sticking].max()), float(forces[nodes.down[sticking]].sum()), state)


class _Nodes:
    """Nodes of the arc: their unknowns sideways and down, and their initial distance to the plate [m]."""

    def __init__(self, body: Body, shape: Shape) -> None:
        x, z = body.place
        arc = shape.curved(np.stack([np.abs(x), z], axis=-1))
        side, down = (np.flatnonzero(arc & (body.component == k)) for k in (0, 1))
        self.side: Integers = side[np.lexsort((z[side], x[side]))]
        self.down: Integers = down[np.lexsort((z[down], x[down]))]
        assert np.allclose(body.place[:, self.side], body.place[:, self.down])
        self.x = np.abs(x[self.down])
        self.gap = z[self.down] + shape.radius
        self.on_axis = self.x <= 1e-9 * shape.radius
        on_plate = np.concatenate([self.side, self.down])
        self._base: Integers = np.setdiff1d(plate_constraint(body, shape, "press", contact=0.0).fixed, on_plate)

    def outermost(self, sticking: Flags) -> int | None:
        """Return the outermost sticking node, None where only the axis sticks."""
        some = sticking & ~self.on_axis
        return int(np.where(some, self.x, -1.0).argmax()) if some.any() else None

    def prescribed(self, sticking: Flags, anchor: Floats, lowered: Floats) -> tuple[Integers, Floats]:
        """Return the prescribed unknowns and their values, with sticking nodes moved by ``lowered``."""
        fixed = np.concatenate(
            [self._base, self.side[self.on_axis], self.side[sticking & ~self.on_axis], self.down[sticking]]
        )
        values = [np.zeros(self._base.size + self.on_axis.sum()), anchor[sticking & ~self.on_axis], lowered[sticking]]
        return fixed, np.concatenate(values)
