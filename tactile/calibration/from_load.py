"""Calibration from a known load at a known speed: the linear thickness constant and the absolute gains."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.calibration.gains import Gains

SURE = 5.0
"""A slope counts that is at least so many of its standard errors away from zero."""
STEADY = 0.5
"""Forces that scatter by more than this share of their mean are no steady load: bare noise seems to press, too."""
LEAST = 5
"""Fewer answers than that calibrate nothing."""


def depth_from_speed(times: ArrayLike, places: ArrayLike, speed: float, depth: float) -> float:
    """Return the depth [m] with which a needle that slides along a straight line is located at its true speed.

    Every located length is proportional to the depth z that the inverse was given, so

        z' = z * speed / |slope of the located places in time|

    by least squares. The forces grow with (z' / z)^2: the absolute gains come after it.

    Arguments: ``times`` (n,) [s]; ``places`` (n, 2) [m] located with ``depth`` [m], within the radius where answers are
    to be right; ``speed`` [m/s], true.

    Raises:
        InputError: shapes that do not match, fewer than 5 answers, times all the same, a speed that is not positive,
            no motion that stands out of the noise.

    Source: Vasarhelyi, Fodor, Roska, sect. 4 and Fig. 8.
    """
    t, at = np.asarray(times, np.float64), np.asarray(places, np.float64)
    if t.ndim != 1 or at.shape != (t.size, 2):
        raise InputError(f"times of shape {t.shape} and places of shape {at.shape}, (n,) and (n, 2) wanted")
    _enough(t, at)
    if not (np.isfinite(speed) and speed > 0):
        raise InputError(f"speed {speed} m/s, a positive number wanted")
    since = t - t.mean()
    spread = float(since @ since)
    if spread == 0:
        raise InputError(f"all {t.size} times are {t[0]} s, a scan that goes on wanted")
    slope = since @ at / spread
    rest = at - at.mean(axis=0) - since[:, None] * slope
    error = float(np.sqrt((rest**2).sum() / (t.size - 2) / spread))
    found = float(np.hypot(*slope))
    if found <= SURE * error:
        raise InputError(
            f"the places move at {found:.3g} +- {error:.3g} m/s, a motion above {SURE:g} standard errors wanted"
        )
    return depth * speed / found


def gains_from_load(gains: Gains, forces: ArrayLike, load: ArrayLike) -> Gains:
    """Return the gains with which the located forces are right on average.

    A located force is proportional to both gains at once, so with one factor for both

        alpha' = alpha * sum(load) / sum(forces)

    and beta_ns stays.

    Arguments: ``forces`` (n,) [N] located with ``gains``; ``load`` [N], one number or (n,).

    Raises:
        InputError: shapes that do not match, fewer than 5 answers, a load that does not press, forces that
            scatter by more than half of their mean.

    Source: Vasarhelyi, Fodor, Roska, sect. 4: "comparing the known load amplitude and the calculated one".
    """
    found = np.asarray(forces, np.float64)
    true = np.asarray(load, np.float64)
    if found.ndim != 1 or true.shape not in ((), found.shape):
        raise InputError(f"forces of shape {found.shape} and loads of shape {true.shape}, (n,) and (n,) or () wanted")
    _enough(found, true)
    if not true.min() > 0:
        raise InputError(f"a load of {true.min()} N, one that presses all the time wanted")
    share = found / true
    mean, scatter = float(share.mean()), float(share.std(ddof=1))
    if not scatter < STEADY * mean:
        raise InputError(
            f"located forces are {mean:.3g} of the load and scatter by {scatter:.3g}, less than {STEADY:g} of their"
            " mean wanted"
        )
    factor = float(true.mean() / found.mean())
    return Gains(gains.shear * factor, gains.normal * factor)


def _enough(first: Floats, second: Floats) -> None:
    if first.size < LEAST:
        raise InputError(f"{first.size} located loads, at least {LEAST} wanted")
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        raise InputError("numbers that are not finite in the scan, finite ones wanted")
