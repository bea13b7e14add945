"""Finite strain: the balance of forces under prescribed displacements by Newton's method."""

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.bump.body import Body, solve
from tactile.bump.plate import Constraint

TOLERANCE = 1e-9
"""Largest out-of-balance forces of a balance, relative to all nodal forces."""
ITERATIONS = 15


def balance(body: Body, start: Floats, fixed: Integers, values: Floats) -> Floats | None:
    """Return the balanced state with the unknowns ``fixed`` at ``values``, None if Newton does not converge.

    The first step is the linear solution about ``start``; steps that invert an element are refused.
    """
    state, free = start, np.ones(body.size, bool)
    free[fixed] = False
    for _ in range(ITERATIONS):
        points = body.at_points(state)
        if not (np.linalg.det(points[0]) > 0).all():
            return None
        residual, matrix = body.both(*points)
        gap = np.abs(residual[free]).sum()
        if gap <= max(TOLERANCE * np.abs(residual).sum(), body.rounding) and np.array_equal(state[fixed], values):
            return state
        state = state + solve(matrix, -residual, fixed, values - state[fixed])
        state[fixed] = values
    return None


def push_to(body: Body, constraint: Constraint, displacement: float) -> Floats:
    """Return the state after the plate of ``constraint`` moves by ``displacement`` [m], in converging steps.

    Raises:
        InputError: steps of a 64th do not converge: elements at the contact's edge are inverted.
    """
    state, reached, step = np.zeros(body.size), 0.0, 1.0
    while reached < 1:
        step = min(step, 1 - reached)
        tried = balance(body, state, constraint.fixed, constraint.state((reached + step) * displacement))
        if tried is not None:
            state, reached = tried, reached + step
            continue
        step /= 2
        if step < 1 / 64:
            raise InputError(
                f"a plate moved by {displacement * 1e6:.4g} um: no balance of forces beyond "
                f"{reached * displacement * 1e6:.4g} um; less, or a wider contact wanted"
            )
    return state
