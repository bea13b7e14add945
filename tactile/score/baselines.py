"""Baseline detectors of a few lines: contact, release and tangential load relative to the held load, slip by a norm."""

import numpy as np

from cnnsim.support import Floats

KINDS = ("contact", "release", "tangential_load", "slip")
"""Kinds of the events of `baseline`."""
TARE = 100
"""Number of frames averaged at the start, which also give the noise."""
SIGMAS = 8.0
"""Noise of the total normal force, above which a contact begins; and of the norm, above which a slip does."""
TOUCHES, GONE = 0.5, 0.3
"""Parts of the largest recent load at which a contact begins and ends."""
AWAY = 0.05
"""Change of the total shear from its mean of the last `REST` seconds, as a part of the load: a tangential load."""
REST, FADE = 0.3, 0.5
"""[s] Memory of the shear, and time constant with which the held load follows the load downwards."""


def baseline(t: Floats, values: Floats, inward: float) -> list[tuple[float, str]]:
    """Return (time, kind) of the events in the readings (frames, rows, cols, 3) of a finger.

    A slip begins where the norm of the shear of all taxels, minus its mean of the last `REST` seconds, exceeds the
    larger of its noise and a fifth of the load.
    """
    tared = np.nan_to_num(values - np.nanmean(values[:TARE], axis=0))
    total = tared.sum(axis=(1, 2)) * (1, 1, inward)
    sigma, shear = float(total[:TARE, 2].std()), tared[..., :2].reshape(len(t), -1)
    noise = float(np.sqrt((shear[:TARE] ** 2).sum(axis=1).mean()))
    found, held, on = list[tuple[float, str]](), 0.0, dict.fromkeys(("contact", "tangential_load", "slip"), False)
    mean = shear[0].copy()
    for n in range(min(TARE, len(t)), len(t)):
        load, dt = total[n, 2], t[n] - t[n - 1]
        held = max(load, held + (load - held) * min(dt / FADE, 1.0))
        mean += (shear[n] - mean) * min(dt / REST, 1.0)
        change = shear[n] - mean
        whole = float(np.hypot(*change.reshape(-1, 2).sum(axis=0)))
        touches = load > max(SIGMAS * sigma, TOUCHES * held) if not on["contact"] else load > GONE * held
        steady = touches and load > 0.9 * held
        now = {
            "contact": touches,
            "tangential_load": steady and whole > max(AWAY * load, SIGMAS * sigma),
            "slip": steady and float(np.linalg.norm(change)) > max(SIGMAS * noise, load / 5),
        }
        found += [(float(t[n]), kind) for kind in now if now[kind] and not on[kind]]
        if on["contact"] and not touches:
            found.append((float(t[n]), "release"))
        on = now
    return found
