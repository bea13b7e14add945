"""Calibration from one straight scan over one taxel: beta_ns, thickness constant, gains and radial correction."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.calibration.file import Calibration
from tactile.calibration.from_load import depth_from_speed, gains_from_load
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection, radial_from_scan
from tactile.calibration.sensitivity import beta_from_scan
from tactile.core.loads import COLUMNS, PLACE, F
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse.taxel import invert_strain

RELIABLE, REACH = 0.75, 1.25
"""Depths from the taxel within which speed and load are compared (150 um of the paper's 200), radii measured."""
ASIDE = 0.1
"""A scan that passes the taxel by more than so many depths is not along y = 0: eq. (18) does not hold for it."""
CUT = 4
"""A smooth peak, rounded to counts so that 3 samples or more share its top, falls by so many counts beside them or by
fewer; one that falls by more was cut off."""
RINGS, SAMPLES = 10, 6
"""Rings of the radial correction, fewer where a ring would have fewer samples."""


def calibrate(
    times: ArrayLike,
    readings: ArrayLike,
    speed: float,
    load: float,
    depth: float,
    modulus: float,
    toward: tuple[float, float] | None = None,
) -> Calibration:
    """Return the calibration from a needle that slides straight over a taxel, at a known speed, with a known load.

    In this order: beta_ns from the extrema (eq. (18)); the depth with which the needle moves at its speed; the gains
    with which all readings near the taxel fit to its load; how far it was when it was located at each radius.

    Arguments: ``times`` (n,) [s]; ``readings`` (n, 3) T_x, T_y, S_n less their tare; ``speed`` [m/s]; ``load`` [N];
    ``depth`` z [m], nominal; ``modulus`` E [Pa]; ``toward``: direction of the slide in the array's
    frame. Without it the direction is found from the shear, whose sign is then taken to be right.

    Raises:
        InputError: shapes that do not match, a speed, load, depth or modulus that is not positive, a scan that
            misses the taxel, is too short or too coarse, leaves the sensor's range, or noise only.

    Source: Vasarhelyi, Fodor, Roska, sects 3.3 and 4.
    """
    t, read = np.asarray(times, np.float64), np.asarray(readings, np.float64)
    if t.ndim != 1 or read.shape != (t.size, 3):
        raise InputError(f"times of shape {t.shape} and readings of shape {read.shape}, (n,) and (n, 3) wanted")
    if not (np.isfinite(t).all() and np.isfinite(read).all() and t.size):
        raise InputError(f"{t.size} readings, some not finite: at least one wanted and all finite")
    for name, value in (("speed", speed), ("load", load), ("depth", depth), ("modulus", modulus)):
        if not 0 < value < np.inf:
            raise InputError(f"{name} {value}, a positive number wanted")
    for name, column in zip(("shear", "shear", "normal"), read.T, strict=True):
        _in_range(name, column)
    top = int(np.abs(read[:, 2]).argmax())
    if toward is None:
        axis = _way(read[:, :2], top)
    elif not 0 < np.hypot(*toward) < np.inf:
        raise InputError(f"direction {toward}, a direction on the surface wanted")
    else:
        axis = np.divide(toward, np.hypot(*toward))
    inward = 1.0 if read[top, 2] < 0 else -1.0  # strain is negative under a load, CONVENTIONS.md
    beta = beta_from_scan(read[:, :2] @ axis, read[:, 2])
    gains = Gains(abs(beta.beta) if toward is None else beta.beta, inward)

    places, _ = _located(read, gains, depth, modulus)
    near = np.abs(t - t[top]) * speed <= RELIABLE * depth
    deeper = depth_from_speed(t[near], places[near], speed, depth)
    places, forces = _located(read, gains, deeper, modulus)
    gains = gains_from_load(gains, forces[near], load)
    places_near, pressed = places[near], forces[near]

    since = t - t[near].mean()
    slope = since[near] @ places[near] / (since[near] @ since[near])
    way = slope / np.hypot(*slope)
    middle = places[near].mean(axis=0)
    aside = float(way[0] * middle[1] - way[1] * middle[0])
    if abs(aside) > ASIDE * deeper:
        raise InputError(
            f"the scan passes {aside * 1e6:.3g} um beside the taxel, at most {ASIDE * deeper * 1e6:.3g} um wanted"
        )
    true = (middle @ way + since * speed)[:, None] * way + aside * np.array([-way[1], way[0]])
    gains = _fitted(gains, read[near], true[near], load, deeper, modulus)
    reach = np.hypot(*true.T) <= REACH * depth
    places, forces = _located(read[reach], gains, deeper, modulus)
    radial = _radial(places, true[reach], forces, load)
    rest = places_near - places_near.mean(axis=0) - since[near][:, None] * slope
    error = np.sqrt((rest**2).sum() / (near.sum() - 2) / (since[near] @ since[near])) / np.hypot(*slope)
    own = beta.sigma / abs(beta.beta)
    share = np.sqrt(np.var(pressed / pressed.mean(), ddof=1) / pressed.size + 4 * error**2 + own**2)  # forces go as z^2
    sigma = (
        float(abs(gains.shear) * np.hypot(share, own)), float(abs(gains.normal) * share), float(deeper * error)
    )  # fmt: skip
    return Calibration(gains, deeper, radial, sigma)


def _fitted(gains: Gains, readings: Floats, places: Floats, load: float, depth: float, modulus: float) -> Gains:
    """Return the gains with which all readings (n, 3) fit best to those under the load at its places (n, 2) [m].

    Located forces, each from three readings alone, are larger on the mean for their noise: by 1.3 % at 3 %.
    """
    rows = np.zeros((len(places), 1, COLUMNS))
    rows[:, 0, PLACE], rows[:, 0, F] = places, load
    true = point_load_strain((0.0, 0.0), depth, rows, modulus)
    factor = float((true * true).sum() / (gains(readings) * true).sum())
    return Gains(gains.shear * factor, gains.normal * factor)


def _way(shear: Floats, top: int) -> Floats:
    """Return the direction of the scan: shear along it changes its sign at the taxel, shear across it does not."""
    half = min(top, len(shear) - 1 - top)
    odd = shear[top : top + half + 1] - shear[top - half : top + 1][::-1]
    return np.asarray(np.linalg.svd(odd, full_matrices=False)[2][0])


def _radial(found: Floats, true: Floats, forces: Floats, load: float) -> RadialCorrection:
    """Return the radial correction with as many rings as stand out of the noise."""
    rings = max(1, min(RINGS, len(found) // SAMPLES))
    while True:
        try:
            return radial_from_scan(found, true, forces, load, rings)
        except InputError:
            if rings == 1:
                raise
            rings -= 1


def _in_range(name: str, readings: Floats) -> None:
    """Refuse readings that stay at an extremum and then fall as no smooth signal does: the range ends there."""
    count = np.diff(np.unique(readings)).min(initial=np.inf)
    for end in (readings.min(), readings.max()):
        at = np.flatnonzero(readings == end)
        run = max(np.split(at, np.flatnonzero(np.diff(at) > 1) + 1), key=len)
        beside = max(readings[[max(run[0] - 1, 0), min(run[-1] + 1, readings.size - 1)]], key=lambda r: abs(r - end))
        high = 2 * abs(end) >= np.abs(readings).max()
        if high and run.size >= 3 and abs(beside - end) > (CUT + 0.5) * count:  # whole counts, less rounding
            raise InputError(
                f"{run.size} {name} readings on end are {end:.4g}, the one beside them {beside:.4g}: cut at the end of"
                " the sensor's range, or repeated; readings within the range wanted"
            )


def _located(readings: Floats, gains: Gains, depth: float, modulus: float) -> tuple[Floats, Floats]:
    """Places (n, 2) [m] and forces (n,) [N] of a pressing load."""
    x, y, z = gains(readings).T
    dx, dy, force, _ = invert_strain(x, y, z, depth, modulus, 0.0, 1)
    return np.stack([np.asarray(dx), np.asarray(dy)], axis=-1), np.asarray(force)
