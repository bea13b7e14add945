"""Whether a contact is turned, compiled: the torque, about the middle of the pressing, of shear that the pressing does
not explain."""

import math

from cnnsim.support.compiled_loops import kept_njit
from tactile.events.signals.step_numba import binary

ALIKE = (0.45, 0.7)
"""Part of the torque that the same shear would make if all of it pointed one way round: off, on."""
MUCH = (0.045, 0.06)
"""Torque over what the load would make at the radius of gyration of its pressing: off, on."""
SIGMAS = (4.0, 6.0)
"""The same in sigma of the torque, which has that of the middle in it."""
LIGHTLY = 0.1
"""Part of what a taxel typically bears: what bears less has no say, and what bore less is taken for one of all."""


@kept_njit(error_model="numpy")
def turn(fast, slow, use, noise_q, noise_n):  # type: ignore[no-untyped-def]  # typed at the call
    """Return a CNN value of how the shear turns, positive for clockwise as seen in the picture (y points down).

    T = sum (r - c) x e over the taxels in ``use`` (rows, cols), c the middle of their pressing and e = s - (s'/n') n:
    their shear less what their pressing n explains, which is that where a contact is pressed harder, unloaded or
    shifted each taxel keeps its shear for a pressing. s, n are the means ``fast``, s', n' ``slow`` (rows, cols, 3). The
    least of T over sum |r - c| |e|, of T over the load times the radius of gyration of the pressing, and of T over its
    noise (``noise_q``, ``noise_n`` of a taxel's shear and pressing) decides.
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
