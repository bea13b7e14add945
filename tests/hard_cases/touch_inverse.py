"""Hard cases of one taxel's inverse: above it, on the ring, far away, signals at the ends of the range, exact zeros."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.support import Array
from tactile.inverse.taxel import STRAIN_INVERSE, STRESS_INVERSE
from tactile.inverse.validity import Validity
from tests.hard_cases.case import HardCase
from tests.oracles.elastic.exact_inverse import exact_inverse
from tests.oracles.elastic.printed_inverse import printed_inverse

UNIT = 3 / (4 * np.pi)
"""Young's modulus at which 4 pi E z^2 / 3 is 1 for a depth of 1."""
ROOT = float(np.sqrt(2))


def signals(ratio: float) -> tuple[float, float]:
    """(|(u_xz, u_yz)|, u_zz) of a normal force of 1 at rho / z, divided by 3 / (4 pi E z^2)."""
    import mpmath  # the ring is known to 1 ulp only with more digits

    with mpmath.workdps(40):
        r = mpmath.mpf(float(ratio))
        return float(3 * r / (1 + r * r) ** 2.5), float((r * r - 2) / (1 + r * r) ** 2.5)


def on_backend(backend: Backend, kind: Any, measured: Any, *parameters: float) -> Array:
    """Return (dx, dy, force, validity) of one taxel."""
    planes = tuple(backend.load(np.full((1, 1), one, np.dtype(backend.dtype)), "lam") for one in measured)
    return np.array([float(backend.read(one)[0, 0]) for one in backend.cellwise(kind, planes, parameters)])


def _strain(shear: float, normal: float, backend: Backend) -> Array:
    """rho and force divided by the exact ones for these signals, rounded to the dtype; 1 and 1 are right."""
    kind = np.dtype(backend.dtype).type
    measured = kind(shear), kind(0), kind(normal)
    dx, _, force, _ = on_backend(backend, STRAIN_INVERSE, measured, 1.0, UNIT, 0.0, 1.0)
    rho, size = exact_inverse(float(measured[0]), float(measured[2]))
    return np.array([abs(dx) / rho if rho else 1.0 + abs(dx), force / size])


def _printed(shear: float, normal: float) -> Array:
    rho, force = printed_inverse(shear, normal, np.float64)
    true, size = exact_inverse(shear, normal)
    return np.array([rho / true if true else 1.0 + rho, force / size])


def _scaled(scale64: float, scale32: float, backend: Backend) -> Array:
    shear, normal = signals(0.8)
    scale = scale64 if backend.dtype == "float64" else scale32
    return _strain(shear * scale, normal * scale, backend)


def _ones() -> Array:
    return np.ones(2)


def _case(name: str, why: str, shear: float, normal: float, **more: Any) -> HardCase:
    naive: Callable[[], Array] = partial(_printed, shear, normal)
    return HardCase(name, why, partial(_strain, shear, normal), _ones, 1e-14, 2e-6, naive, **more)


def _naive_stress() -> Array:
    """Eqs (10), (11) as printed: (rho / z)^2 = (s_xz^2 + s_yz^2) / s_zz^2 without a guard."""
    shear, normal = np.float64(1.0), np.float64(0.0)
    t = shear * shear / (normal * normal)
    return np.array([np.sqrt(t), 0.0, normal * (t + 1) ** 2.5, float(Validity.INVALID)])


SQUARES = "squares of the signals leave the range of the numbers"
SPREADS = "the value of a broken wire must not enter a program"
INVALID, NO_LOAD = (0.0, 0.0, 0.0, float(Validity.INVALID)), (0.0, 0.0, 0.0, float(Validity.NO_LOAD))
TINY = 5e-324


def _same(
    name: str, why: str, kind: Any, measured: tuple[float, float, float], exact: tuple[float, ...], **more: Any
) -> HardCase:
    """A case whose answer (dx, dy, force, validity) is known exactly."""
    parameters = (1.0, UNIT, 0.0, 1.0) if kind is STRAIN_INVERSE else (1.0, 0.0)
    ours = partial(_answer, kind, measured, parameters)
    return HardCase(name, why, ours, lambda: np.array(exact), 0.0, 0.0, **more)


def _answer(kind: Any, measured: Any, parameters: tuple[float, ...], backend: Backend) -> Array:
    return on_backend(backend, kind, measured, *parameters)


CASES = [
    _case("rho = 0", "the azimuth is 0/0", 0.0, -2.0, naive_fails=False),
    _case("rho = 1e-9 z", "2 - 12 / (sqrt(9 + 8 A^2) + 3) cancels", *signals(1e-9)),
    _case("rho = 1e-4 z", "the same, with half of the digits", *signals(1e-4)),
    *(
        _case(f"rho = sqrt(2) z{word}", "u_zz vanishes: F is 0/0", *signals(ratio))
        for word, ratio in ((" - 1 ulp", np.nextafter(ROOT, 0)), ("", ROOT), (" + 1 ulp", np.nextafter(ROOT, 2)))
    ),
    _case("u_zz exactly 0", "the ring itself: A is infinite", 0.5, 0.0),
    _case("rho = 1e6 z", "sqrt(9 + 8 A^2) - 3 cancels", *signals(1e6)),
    _same(
        "rho = 1e7 z", "a load farther than a million depths cannot be located", STRAIN_INVERSE,
        (3e-7, 0.0, 1.0), INVALID,
    ),
    *(
        HardCase(
            f"signals of {scale64:g} (float32: {scale32:g})", SQUARES, partial(_scaled, scale64, scale32), _ones,
            1e-14, 2e-6, partial(_printed, *(scale64 * part for part in signals(0.8))),
        )
        for scale64, scale32 in ((1e-300, 1e-37), (1e300, 1e37))
    ),
    _same(
        "denormal signals", "denormal numbers have too few digits: no load is given", STRAIN_INVERSE,
        (TINY, 0.0, -TINY), NO_LOAD,
    ),
    *(
        _same(f"{value} in a signal of {name}", SPREADS, kind, (value, 0.0, -1.0), INVALID)
        for name, kind in (("strain", STRAIN_INVERSE), ("stress", STRESS_INVERSE))
        for value in (float("nan"), float("inf"), float("-inf"))
    ),
    _same(
        "-0.0 in all signals", "the sign of zero must not become a load", STRAIN_INVERSE, (-0.0, -0.0, -0.0), NO_LOAD,
    ),
    _same(
        "stress, sigma_zz exactly 0", "rho = z hypot / 0: the load cannot be located", STRESS_INVERSE,
        (1.0, 0.0, 0.0), INVALID, naive=_naive_stress,
    ),
]  # fmt: skip
