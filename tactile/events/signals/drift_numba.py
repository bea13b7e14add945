"""Drift, compiled: what all taxels come to read together, and each one that nothing presses, is taken off."""

import math

from cnnsim.support.compiled_loops import kept_njit

FOLLOWS = 0.3
"""[s] Time constant: what grows by less than the level in that time is drift."""
LITTLE = 0.05
"""A level above this part of what a pressed taxel bears may have a part of the contact below it."""
TOGETHER = 0.05
"""[s] Time constant of what taxels that nothing presses read together, ..."""
MOST_OF, WEAK = 0.25, 2.0
"""... where these are more than this part of all, and a contact bears more than so many levels on a pressed taxel."""


@kept_njit(error_model="numpy")
def follow(values, fast, use, off, on, most, fastest, dt, contact, common, base, out):  # type: ignore[no-untyped-def]  # typed at the call
    """Move ``common`` (3,) and ``base`` (rows, cols, 3) towards what unpressed taxels read; write ``values`` less both
    to ``out``.

    A taxel is unpressed while its mean ``fast``, which is less both already, is below its level ``on`` of pressing; for
    ``common`` in a ``contact`` below ``off``, above which one that was pressed still is.
    ``common`` goes towards where most of them are (a mean in which none counts for more than ``fastest`` (3,) [1/s]
    times `TOGETHER`), so no faster than ``fastest``. A component of the base, of pressing in a ``contact`` alone, is
    followed while it is below its level, too, and, in a contact, the level of pressing is little beside what a pressed
    taxel bears: in a light one nothing is. What comes faster than a level in `FOLLOWS` stays, and so does what is more
    than ``most`` (3,) in all. With ``dt`` 0 [s] nothing moves.
    """
    rows, cols = use.shape
    part, together = 1 - math.exp(-dt / FOLLOWS), 1 - math.exp(-dt / TOGETHER)
    force = squares = level = 0.0
    count = free = 0
    for i in range(rows):
        for j in range(cols):
            if use[i, j]:
                count += 1
                level += on[i, j, 2]
                free += fast[i, j, 2] < (off[i, j, 2] if contact else on[i, j, 2])
                if fast[i, j, 2] > 0:
                    force += fast[i, j, 2]
                    squares += fast[i, j, 2] ** 2
    weak = contact and squares * count < WEAK * level * force
    if free > MOST_OF * count and dt > 0 and not weak:
        for k in range(3):
            far, away = fastest[k] * TOGETHER, 0.0
            for i in range(rows):
                for j in range(cols):
                    if use[i, j] and fast[i, j, 2] < (off[i, j, 2] if contact else on[i, j, 2]):
                        away += min(max(fast[i, j, k] + base[i, j, k], -far), far)
            common[k] = min(max(common[k] + together * away / free, -most[k]), most[k])
    least = LITTLE * squares / force if force > 0 else 0.0
    for i in range(rows):
        for j in range(cols):
            moves = part > 0 and use[i, j] and fast[i, j, 2] < on[i, j, 2] and (on[i, j, 2] < least or not contact)
            for k in range(3):
                # what presses one taxel more than the others while nothing is told of may be a slow touch
                if moves and (contact or k < 2) and abs(fast[i, j, k]) < on[i, j, k]:
                    base[i, j, k] = min(max(base[i, j, k] + part * fast[i, j, k], -most[k]), most[k])
                out[i, j, k] = values[i, j, k] - common[k] - base[i, j, k]
