"""From raw readings to strain: tare, gains, and the normal-to-shear sensitivity from a scan."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.support.errors import InputError
from tactile.core.frame import Frame

EXTREMA_RATIO = 25 * np.sqrt(5) / 24
"""|u_zz(x = 0)| / |u_xz(x = z / 2)| on the line y = 0 under a normal load: eq. (18)."""
STENCIL = 3
"""The refined extremum uses that many samples on either side of the largest one."""


class Tare:
    """Subtracts the mean of one finger's first ``frames`` frames, during which nothing may touch it.

    Called with a frame, gives the frame less the mean. The frames that are still being averaged come back with no
    valid taxel. A taxel's invalid readings do not count; one without any valid reading stays invalid.

    Raises:
        InputError: a negative number of frames.
    """

    def __init__(self, frames: int) -> None:
        if frames < 0:
            raise InputError(f"tare over {frames} frames, 0 or more wanted")
        self._left = frames
        self._sum: NDArray[np.float64] | float = 0.0
        self._count: NDArray[np.int64] | int = 0
        self._offset: NDArray[np.float64] | float = 0.0

    @property
    def ready(self) -> bool:
        """Whether the mean is complete."""
        return self._left == 0

    def __call__(self, frame: Frame) -> Frame:
        """Return the frame less the mean, or with no valid taxel while the mean is being made."""
        if self._left == 0:
            return self._tared(frame)
        usable = frame.valid & np.isfinite(frame.values).all(-1)
        self._sum = self._sum + np.where(usable[..., None], frame.values, 0.0)
        self._count = self._count + usable.astype(np.int64)
        self._left -= 1
        if self._left == 0:
            seen = np.asarray(self._count)[..., None]
            self._offset = np.where(seen > 0, self._sum / np.maximum(seen, 1), np.nan)
        return replace(frame, valid=np.zeros_like(frame.valid))

    def _tared(self, frame: Frame) -> Frame:
        values = frame.values - self._offset
        return replace(frame, values=values, valid=frame.valid & np.isfinite(values).all(-1))


@dataclass(frozen=True)
class Gains:
    """The linear coefficients of a taxel: u = (shear, shear, normal) * (T_x, T_y, S_n).

    Arguments: ``shear`` alpha_s and ``normal`` alpha_n [unit of the strain per unit of the reading].

    Raises:
        InputError: a coefficient that is zero or not finite.

    Source: Vasarhelyi, Fodor, Roska, eq. (15).
    """

    shear: float
    normal: float

    def __post_init__(self) -> None:
        for name, value in (("shear", self.shear), ("normal", self.normal)):
            if not np.isfinite(value) or value == 0:
                raise InputError(f"{name} gain {value}, a finite number other than 0 wanted")

    @property
    def beta_ns(self) -> float:
        """Normal-to-shear sensitivity alpha_s / alpha_n, so that A = beta_ns A_m: eq. (16)."""
        return self.shear / self.normal

    def __call__(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return strains (..., 3) of the readings (..., 3)."""
        strain: NDArray[np.float64] = values * np.array([self.shear, self.shear, self.normal])
        return strain


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


def _maximum(samples: NDArray[np.float64], name: str) -> float:
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
