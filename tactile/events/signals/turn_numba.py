"""Whether a contact is turned, compiled: the torque of the change of shear about the middle of the pressing."""

import math

from numba import njit

from tactile.events.signals.step_numba import binary

ALIKE = (0.4, 0.6)
"""Part of the torque that the same changes would make if all pointed one way round: off, on."""
MUCH = (0.045, 0.07)
"""Torque over what the load would make at the radius of gyration of its pressing: off, on."""
SIGMAS = (4.0, 6.0)
"""The same in sigma of the torque, which has that of the middle in it."""


@njit(cache=True, error_model="numpy")
def turn(fast, slow, use, noise_q, noise_n):  # type: ignore[no-untyped-def]  # typed at the call
    """Return a CNN value of how the shear turns, positive for clockwise as seen in the picture (y points down).

    T = sum (r - c) x d over the taxels in ``use`` (rows, cols), c the middle of their pressing and d the change of
    their shear, the mean ``fast`` less ``slow`` (rows, cols, 3). The least of T over sum |r - c| |d|, of T over the
    load times the radius of gyration of the pressing, and of T over its noise (``noise_q``, ``noise_n`` of a taxel's
    shear and pressing) decides.
    """
    rows, cols = use.shape
    force = x = y = 0.0
    for i in range(rows):
        for j in range(cols):
            press = fast[i, j, 2]
            if use[i, j] and press > 0:
                force += press
                x += press * j
                y += press * i
    if not force > 0:
        return 0.0
    x, y = x / force, y / force
    torque = most = arm = noise = doubt = q = r = 0.0
    for i in range(rows):
        for j in range(cols):
            if use[i, j]:
                along, across = j - x, i - y
                dx, dy = fast[i, j, 0] - slow[i, j, 0], fast[i, j, 1] - slow[i, j, 1]
                away = along * along + across * across
                torque += along * dy - across * dx
                most += math.sqrt(away * (dx * dx + dy * dy))
                arm += away * max(fast[i, j, 2], 0.0)
                noise += away * noise_q[i, j] ** 2
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
