"""One wave in a layer bonded to a rigid base: growing and falling exponentials, a linear system, any precision."""

from typing import Any

import numpy as np

from cnnsim.support import Floats


def mp_transfer(k: float, depth: float, thickness: float, nu: float, digits: int = 80) -> Floats:
    """Strain readings (normal, shear_normal, normal_shear, shear) of ``elastic.layer.transfer`` at G = 1.

    Digits enough for the growing waves are added. nu = 1/2 is taken as its limit.
    """
    import mpmath  # only here: an oracle that not all tests need

    with mpmath.workdps(int(digits + k * thickness)):
        number = mpmath.mpf(nu) if nu < 0.5 else mpmath.mpf(1) / 2 - mpmath.mpf(10) ** -(digits // 2)
        given = mpmath.mpf(k), mpmath.mpf(depth), mpmath.mpf(thickness), number
        return np.array([float(part) for part in _readings(*given, exp=mpmath.exp, solve=_mp_solve)])


def float_transfer(k: float, depth: float, thickness: float, nu: float) -> Floats:
    """The same in float64: what one would write first."""
    first, *rest = (np.float64(part) for part in (k, depth, thickness, nu))
    try:
        return np.array(_readings(first, *rest, exp=np.exp, solve=np.linalg.solve), np.float64)
    except np.linalg.LinAlgError:
        return np.full(4, np.nan)


def _mp_solve(matrix: Any, right: Any) -> Any:
    import mpmath

    return list(mpmath.lu_solve(mpmath.matrix(matrix), mpmath.matrix(right)))


def _readings(k: Any, depth: Any, h: Any, nu: Any, *, exp: Any, solve: Any) -> list[Any]:
    """Displacement (i U, W) = a (e, -e) + b (kz e, -(kz + kappa) e) + c (g, g) + d (-kz g, (kappa - kz) g).

    e = exp(-kz), g = exp(kz).
    U = W = 0 at z = h; at the top sigma_zz = lambda (W' - k U) + 2 W' and sigma_sz / i = U' + k W are the tractions.
    """
    kappa, lam = 3 - 4 * nu, 2 * nu / (1 - 2 * nu)

    def waves(z: Any) -> list[tuple[Any, Any, Any, Any]]:
        """(U, W, U', W') of the four."""
        e, g, s = exp(-k * z), exp(k * z), k * z
        return [
            (e, -e, -k * e, k * e),
            (s * e, -(s + kappa) * e, k * (1 - s) * e, k * (s + kappa - 1) * e),
            (g, g, k * g, k * g),
            (-s * g, (kappa - s) * g, -k * (1 + s) * g, k * (kappa - s - 1) * g),
        ]

    top, base, at = waves(0 * k), waves(h), waves(depth)
    matrix = [
        [one[0] for one in base],
        [one[1] for one in base],
        [lam * (one[3] - k * one[0]) + 2 * one[3] for one in top],
        [one[2] + k * one[1] for one in top],
    ]
    out = []
    for right in ([0, 0, -1, 0], [0, 0, 0, 1]):
        a = solve(matrix, right)
        normal = sum(x * one[3] for x, one in zip(a, at, strict=True))
        shear = sum(x * (one[2] + k * one[1]) for x, one in zip(a, at, strict=True)) / 2
        # under q_s the amplitudes are imaginary: i times i turns the sign of the shear reading
        out += [normal, shear if right[2] else -shear]
    return out
