"""Baseline detectors of ten lines: fixed thresholds on the summed forces of a finger."""

import numpy as np

from cnnsim.support import Floats

TARE = 100
"""Number of frames averaged at the start."""
ON, OFF = 0.3, 0.15
"""[N] Total normal force at which contact begins, and ends."""
AWAY = 0.2
"""[N] Change of the total shear force from the mean of the last `REST` frames that begins a tangential load."""
REST = 150


def baseline(t: Floats, values: Floats, inward: float) -> list[tuple[float, str]]:
    """Return (time, kind) of the events of fixed thresholds in the values (frames, rows, cols, 3) of a finger."""
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
"""Shear over pressing at which slip begins: a guessed friction."""


def slip_baseline(t: Floats, values: Floats) -> list[tuple[float, str]]:
    """Return (time, "slip") where the total shear force exceeds a fixed part of the total normal force."""
    total = np.nansum(values - np.nanmean(values[:TARE], axis=0), axis=(1, 2))
    slides = (total[:, 2] > ON) & (np.hypot(total[:, 0], total[:, 1]) > RATIO * total[:, 2])
    return [(float(t[n]), "slip") for n in np.flatnonzero(slides[1:] & ~slides[:-1]) + 1]
