"""The inverse of one strain taxel in high precision, from signals taken as exact."""

from typing import Any


def exact_inverse(shear: Any, normal: Any, digits: int = 60) -> tuple[float, float]:
    """Return rho / z, and F over 4 pi E z^2 / 3, of signals |(u_xz, u_yz)| and u_zz of a load that presses.

    By eq. (1) a / |b| = 3 r / |r^2 - 2| with r = rho / z: quadratic in r, solved in many digits on the side
    given by u_zz; then the load from the length of the signals, which vanishes nowhere.
    """
    import mpmath  # only here: an oracle that not all tests need

    with mpmath.workdps(digits):
        a, b = mpmath.mpf(float(shear)), mpmath.mpf(float(normal))
        # inside: a (2 - r^2) = 3 r |b|, outside: a (r^2 - 2) = 3 r |b|
        if a == 0:
            r = mpmath.mpf(0)
        else:
            half = 3 * abs(b) / (2 * a)
            r = mpmath.sqrt(half * half + 2) - half if b < 0 else mpmath.sqrt(half * half + 2) + half
        t = r * r
        size = mpmath.hypot(a, b) * (1 + t) ** mpmath.mpf(2.5) / mpmath.sqrt((1 + t) * (4 + t))
        return float(r), float(size)
