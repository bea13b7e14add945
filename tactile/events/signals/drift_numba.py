"""Drift of taxels that nothing presses, compiled: what they come to read by and by in a contact is taken off."""

import math

from numba import njit

FOLLOWS = 0.3
"""[s] Time constant: what grows by less than the level in that time is drift."""
LITTLE = 0.05
"""A level above this part of what a pressed taxel bears may have a part of the contact below it."""


@njit(cache=True, error_model="numpy")
def follow(values, fast, use, on, most, dt, base, out):  # type: ignore[no-untyped-def]  # typed at the call
    """Move ``base`` (rows, cols, 3) towards what unpressed taxels read, and write ``values`` less ``base`` to ``out``.

    A component is followed while its mean ``fast``, which is less ``base`` already, is below its level ``on``, and so
    is that of the taxel's pressing, a level that is little beside what a pressed taxel bears: in a light contact
    nothing is. What comes faster than a level in `FOLLOWS` stays, and so does what is more than ``most`` (3,) in all.
    With ``dt`` 0 [s] nothing moves.
    """
    rows, cols = use.shape
    part = 1 - math.exp(-dt / FOLLOWS)
    force = squares = 0.0
    for i in range(rows):
        for j in range(cols):
            if use[i, j] and fast[i, j, 2] > 0:
                force += fast[i, j, 2]
                squares += fast[i, j, 2] ** 2
    least = LITTLE * squares / force if force > 0 else 0.0
    for i in range(rows):
        for j in range(cols):
            moves = part > 0 and use[i, j] and fast[i, j, 2] < on[i, j, 2] < least
            for k in range(3):
                if moves and abs(fast[i, j, k]) < on[i, j, k]:
                    base[i, j, k] = min(max(base[i, j, k] + part * fast[i, j, k], -most[k]), most[k])
                out[i, j, k] = values[i, j, k] - base[i, j, k]
