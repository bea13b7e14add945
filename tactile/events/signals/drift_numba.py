"""Drift compensation, compiled: common drift, drift of each unpressed taxel, uniform part of a load in a release."""

import math

from cnnsim.support.compiled_loops import kept_njit

FOLLOWS = 0.3
"""[s] Time constant: growth below one level in this time is drift."""
LITTLE = 0.05
"""Part of the load of a pressed taxel, below which the level of another taxel must lie: no contact hides below it."""
TOGETHER = 0.05
"""[s] Time constant of the common drift."""
MOST_OF, WEAK = 0.25, 2.0
"""The common drift needs this part of all taxels unpressed, and a contact of more than this many levels on a pressed
taxel."""


@kept_njit(error_model="numpy")
def follow(values, fast, use, off, on, most, fastest, dt, contact, common, base, out):  # type: ignore[no-untyped-def]  # typed at the call
    """Update the drift estimates from unpressed taxels and write the compensated readings to ``out``.

    ``common`` (3,) is the drift of all taxels, ``base`` (rows, cols, 3) the remaining drift of each; out = values -
    common - base. A taxel is unpressed while its compensated mean ``fast`` is below its level ``on`` of pressing; for
    ``common`` in a ``contact`` below ``off``, above which a taxel that was pressed still is. ``common`` follows the
    mean of the unpressed taxels, each clipped to ``fastest`` (3,) [1/s] times `TOGETHER`, so it moves no faster than
    ``fastest``. A component of ``base`` (in a ``contact`` only pressing) follows while it is below its level and, in a
    contact, while the level of pressing is small next to the load of a pressed taxel. Changes faster than one level in
    `FOLLOWS`, and more than ``most`` (3,) in all, remain in the readings. With ``dt`` 0 [s] nothing changes.
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
                # without a contact, pressing of a single taxel may be a slow touch
                if moves and (contact or k < 2) and abs(fast[i, j, k]) < on[i, j, k]:
                    base[i, j, k] = min(max(base[i, j, k] + part * fast[i, j, k], -most[k]), most[k])
                out[i, j, k] = values[i, j, k] - common[k] - base[i, j, k]


UNLIKE = 0.15
"""Relative spread of the pressing below which a pattern counts as uniform (regularises the fit)."""


@kept_njit(error_model="numpy")
def flat(fast, held, use, a, most):  # type: ignore[no-untyped-def]  # typed at the call
    """Return the pressing that is uniform over all taxels and not part of the grip, at most ``most`` each.

    The pressing p of the taxels in ``use`` (rows, cols), from the mean ``fast`` (rows, cols, 3), is fitted by c + b h
    in least squares. h is their recent load ``held`` (rows, cols), which moves towards p by the factor ``a``. In a
    release b falls to 0, and the rest of p is drift or creep. c is 0 where h is uniform.
    """
    rows, cols = use.shape
    count = 0
    p = h = hh = ph = 0.0
    for i in range(rows):
        for j in range(cols):
            held[i, j] += a * (fast[i, j, 2] - held[i, j])
            if use[i, j]:
                count += 1
                p += fast[i, j, 2]
                h += held[i, j]
                hh += held[i, j] ** 2
                ph += fast[i, j, 2] * held[i, j]
    if not h > 0:
        return 0.0
    p, h = p / count, h / count
    little = (UNLIKE * h) ** 2
    b = (ph / count - p * h + little * p / h) / (hh / count - h * h + little)
    return count * min(max(p - b * h, 0.0), most)
