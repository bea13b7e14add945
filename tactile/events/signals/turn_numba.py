"""Torque of a contact, compiled: turning shear about the centre of pressure beyond what the pressing explains."""

import math

from cnnsim.support.compiled_loops import kept_njit
from tactile.events.signals.step_numba import binary

ALIKE = (0.45, 0.7)
"""Torque over the largest torque of the same shear magnitudes: off, on."""
MUCH = (0.045, 0.06)
"""Torque over the load times the radius of gyration of its pressing: off, on."""
SIGMAS = (4.0, 6.0)
"""Torque over its sigma, including that of the centre of pressure: off, on."""
LIGHTLY = 0.1
"""Part of the typical load of a taxel, below which a taxel is ignored or regularised by the mean ratio."""


@kept_njit(error_model="numpy")
def turn(fast, slow, use, noise_q, noise_n):  # type: ignore[no-untyped-def]  # typed at the call
    """Return a CNN value of the torque, positive for clockwise as seen in the picture (y points down).

    T = sum (r - c) x e over the taxels in ``use`` (rows, cols). c is the centre of pressure; e = s - (s'/n') n is the
    shear that the pressing does not explain, with means s, n ``fast`` and s', n' ``slow`` (rows, cols, 3). The least of
    three ratios decides: T over sum |r - c| |e|, T over the load times the radius of gyration of the pressing, and T
    over its noise (``noise_q``, ``noise_n`` of shear and pressing of a taxel).
    """
    rows, cols = use.shape
    force = x = y = slow_n = slow_q = slow_r = squares = 0.0
    for i in range(rows):
        for j in range(cols):
            if use[i, j]:
                press, before = max(fast[i, j, 2], 0.0), max(slow[i, j, 2], 0.0)
                force += press
                x += press * j
                y += press * i
                slow_n += before
                slow_q += slow[i, j, 0]
                slow_r += slow[i, j, 1]
                squares += before * before
    if not (force > 0 and slow_n > 0):
        return 0.0
    x, y = x / force, y / force
    few = LIGHTLY * squares / slow_n
    ratio_q, ratio_r = slow_q / slow_n, slow_r / slow_n
    torque = most = arm = noise = doubt = q = r = 0.0
    for i in range(rows):
        for j in range(cols):
            press, before = max(fast[i, j, 2], 0.0), max(slow[i, j, 2], 0.0) + few
            if use[i, j] and max(press, before - few) >= few:
                along, across = j - x, i - y
                of_q, of_r = (slow[i, j, 0] + few * ratio_q) / before, (slow[i, j, 1] + few * ratio_r) / before
                dx, dy = fast[i, j, 0] - of_q * press, fast[i, j, 1] - of_r * press
                away = along * along + across * across
                torque += along * dy - across * dx
                most += math.sqrt(away * (dx * dx + dy * dy))
                arm += away * press
                own = noise_q[i, j] ** 2 + (of_q * of_q + of_r * of_r) * noise_n[i, j] ** 2
                noise += away * own * (1 + (press / before) ** 2)
                doubt += away * noise_n[i, j] ** 2
                q += dx
                r += dy
    size = abs(torque)
    if not size > 0:
        return 0.0
    whole, noise = math.sqrt(arm * force), math.sqrt(noise + (q * q + r * r) * doubt / force**2)
    level = binary(size / most, ALIKE[0], ALIKE[1])
    level = min(level, binary(size, MUCH[0] * whole, MUCH[1] * whole))
    level = min(level, binary(size, SIGMAS[0] * noise, SIGMAS[1] * noise))
    return math.copysign(level, torque)
