"""Normal-to-shear sensitivity beta_ns of a taxel, from the extrema of a scan over it."""

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError

EXTREMA_RATIO = 25 * np.sqrt(5) / 24
"""|u_zz(x = 0)| / |u_xz(x = z / 2)| on the line y = 0 under a normal load: eq. (18)."""
STENCIL = 3
"""The refined extremum uses that many samples on either side of the largest one."""


def beta_from_scan(shear: ArrayLike, normal: ArrayLike) -> float:
    """Return beta_ns from a scan with a constant normal load along y = 0, right over the taxel.

        beta_ns = (|S_n|max / |T_x|max) / (25 sqrt(5) / 24)

    |T_x|max is the mean of both lobes, so that a constant offset of the shear signal drops out. Between equally
    spaced samples an extremum is that of the polynomial through the largest sample and its three neighbours on
    either side. On noiseless data of spacing h that is off by up to 70 (h / z)^7, and by rounding only where
    samples hit the extrema and h is z / 20 or less. It does not smooth: filter a noisy scan first.

    Arguments: ``shear``, ``normal`` (n,) readings T_x, S_n at equally spaced places along the scan.

    Raises:
        InputError: shapes that differ, numbers that are not finite, a scan without all three extrema inside.

    Source: Vasarhelyi, Fodor, Roska, eq. (18).
    """
    t, s = np.asarray(shear, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    if t.ndim != 1 or t.shape != s.shape:
        raise InputError(f"shear of shape {t.shape} and normal of shape {s.shape}, two equal (n,) wanted")
    if not (np.isfinite(t).all() and np.isfinite(s).all()):
        raise InputError("the scan has NaN or infinite readings, finite ones wanted")
    if not t.size or not t.any() or not s.any():
        raise InputError("the scan has no signal, one over a loaded taxel wanted")
    sign = np.sign(s[np.abs(s).argmax()])
    peak = _maximum(sign * s, "normal")
    swing = (_maximum(t, "shear") + _maximum(-t, "shear")) / 2
    return float(peak / swing / EXTREMA_RATIO)


def _maximum(samples: Floats, name: str) -> float:
    """Return the refined largest value: the polynomial through 2 STENCIL + 1 samples, climbed by Newton."""
    top = int(samples.argmax())
    if not STENCIL <= top < samples.size - STENCIL:
        raise InputError(
            f"the {name} extremum is sample {top} of {samples.size}: the scan must go on for {STENCIL} more"
            " samples beyond every extremum"
        )
    steps = np.arange(-STENCIL, STENCIL + 1, dtype=np.float64)
    polynomial = np.poly1d(np.linalg.solve(np.vander(steps), samples[top - STENCIL : top + STENCIL + 1]))
    slope, bend = polynomial.deriv(), polynomial.deriv(2)
    at = 0.0
    for _ in range(8):
        if bend(at) >= 0:  # a plateau or a kink: there is nothing to climb
            return float(samples[top])
        at = float(np.clip(at - slope(at) / bend(at), -0.6, 0.6))
    return float(max(polynomial(at), samples[top]))
