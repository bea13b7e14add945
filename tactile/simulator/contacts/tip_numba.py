"""Bounds of what tips press harder on a layer that rises, compiled."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

STEEPER = 1.02
"""Slopes between two places of a table are at most so many times the line's."""


@kept_helper(error_model="numpy")
def _between(at, places, values):  # type: ignore[no-untyped-def]  # numba types it at the call
    """A table's value at a place, by the straight line between its nearest two."""
    n = min(max(np.searchsorted(places, at), 1), places.size - 1)
    share = (at - places[n - 1]) / (places[n] - places[n - 1])
    return values[n - 1] + share * (values[n] - values[n - 1])


@kept_njit(error_model="numpy")
def most_pressed(force, rises, thickness, modulus, deep, known):  # type: ignore[no-untyped-def]  # the same
    """Bound of a force > 0 after rises (n, 2), each with the radius R of its tip, of a layer h thick.

    Arguments: ``deep``, ``known``: logarithms of indentations over h^2 / R, and of the forces there over E* h^3 / R.
    """
    for k in range(rises.shape[0]):
        rise, radius = rises[k, 0], rises[k, 1]
        pressed = math.log(force * radius / (modulus * thickness**3))
        deeper = math.log(math.exp(_between(pressed, known, deep)) + rise * radius / thickness**2)
        force *= 1 + STEEPER * math.expm1(_between(deeper, deep, known) - pressed)
    return force


@kept_njit(error_model="numpy")
def most_raised(forces, readings, before, rises, thickness, modulus, deep, known):  # type: ignore[no-untyped-def]  # the same
    """Bound of the change of readings (frames,) under forces (frames, n) when rises come after those before.

    A larger force grows by more, and by a smaller part of itself: of most frames that tells that they change by less
    than those where readings are largest.
    """
    first, out, added, growth, hard = readings.argmax(), 0.0, np.inf, np.inf, np.inf
    for step in range(-1, readings.size):
        frame = first if step < 0 else step
        for m in range(forces.shape[1]):
            force = forces[frame, m]
            if force > 0 and (growth if force >= hard else added / force) * readings[frame] > out:
                least = most_pressed(force, before, thickness, modulus, deep, known)
                more = most_pressed(least, rises, thickness, modulus, deep, known) - least
                if more / force * readings[frame] > out:
                    out, added, growth, hard = more / force * readings[frame], more, more / force, force
    return out
