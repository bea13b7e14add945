"""Ten-line detectors that a real one has to beat: fixed thresholds on the sums of a finger's forces."""

import numpy as np

from cnnsim.support import Floats

TARE = 100
"""Frames averaged away at the start."""
ON, OFF = 0.3, 0.15
"""[N] Contact begins and ends with the total normal force."""
AWAY = 0.2
"""[N] Tangential load begins when the total shear force leaves that of the last `REST` frames by so much."""
REST = 150


def baseline(t: Floats, values: Floats, inward: float) -> list[tuple[float, str]]:
    """Return (time, kind) of what fixed thresholds find in one finger's values (frames, rows, cols, 3)."""
    total = np.nansum(values - np.nanmean(values[:TARE], axis=0), axis=(1, 2)) * (1, 1, inward)
    found, touches = [], False
    for n in range(TARE, len(t)):
        if (total[n, 2] > ON and not touches) or (total[n, 2] < OFF and touches):
            touches = not touches
            found.append((float(t[n]), "contact" if touches else "release"))
        held = total[max(n - REST, 0) : n, :2].mean(axis=0)
        if touches and n % REST == 0 and np.hypot(*(total[n, :2] - held)) > AWAY:
            found.append((float(t[n]), "tangential_load"))
    return found


RATIO = 0.5
"""Slip begins when shear passes this part of the pressing, as with a friction that somebody guessed."""


def slip_baseline(t: Floats, values: Floats) -> list[tuple[float, str]]:
    """Return (time, "slip") of where the total shear force passes a fixed part of the total normal force."""
    total = np.nansum(values - np.nanmean(values[:TARE], axis=0), axis=(1, 2))
    slides = (total[:, 2] > ON) & (np.hypot(total[:, 0], total[:, 1]) > RATIO * total[:, 2])
    return [(float(t[n]), "slip") for n in np.flatnonzero(slides[1:] & ~slides[:-1]) + 1]
