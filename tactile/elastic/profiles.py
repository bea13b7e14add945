"""Axisymmetric pressures on a circle as weights on a line of complex sources, and the laws of their indenters.

Any axisymmetric density on a circle of radius a acts like a line of complex point sources at depths -i t,

    potential(rho, z) = integral over t = -a .. a of  w(t) / sqrt(rho^2 + (z + i t)^2),

so one even weight w(t), with integral 1, defines a profile. With t = a sin(theta) every weight here is smooth in
theta. Source: Copson (1947); Johnson, Contact Mechanics, sect. 3.8; Sneddon (1965).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from cnnsim.support.compiled_loops import kept_njit
from tactile.elastic.gauss import gauss


@dataclass(frozen=True)
class Profile:
    """A shape of pressure. ``weight(theta, lam)`` is w(t) dt / d theta, integral over -pi/2 .. pi/2 equal to 1.

    ``lam`` is the contact radius over the length that the shape depends on (the tip's radius, a layer's thickness), 0
    elsewhere; ``limit``: the largest lam, an asymptote; ``waves``: its Hankel transform over k a, where that has
    a closed form; ``turned``: of a tangential load on a layer the weight of a part that lies along
    (cos 2 phi, sin 2 phi) where the load is along x, integral 0.
    """

    name: str
    weight: Callable[[Floats, Floats], Floats]
    limit: float = np.inf
    waves: Callable[[Floats], Floats] | None = None
    turned: Callable[[Floats, Floats], Floats] | None = None

    def mean_radius(self, lam: Floats) -> Floats:
        """Return the mean distance of the pressure from the middle, over the circle's radius, for lam (...).

        pi times the integral of t w(t) from 0 to 1: 3 pi / 16 of Hertz' pressure, pi / 4 under a flat end.
        """
        nodes, weights = gauss(48)
        theta, step = (nodes + 1) * np.pi / 4, weights * np.pi**2 / 4
        at = np.broadcast_to(theta, (*np.shape(lam), len(theta)))
        mean: Floats = self.weight(at, np.asarray(lam)[..., None]) @ (step * np.sin(theta))
        return mean


def _sphere_weight(theta: Floats, lam: Floats) -> Floats:
    # w(t) ~ a atanh(lam) - t atanh(lam t / a): Sneddon's rigid sphere; the paraboloid's a^2 - t^2 where lam is small
    deep = np.clip(lam, 1e-3, 1 - 1e-12)
    t = np.abs(np.sin(theta))
    whole = ((1 + deep**2) * np.arctanh(deep) - deep) / deep**2
    shape = np.cos(theta) * (np.arctanh(deep) - t * np.arctanh(deep * t)) / whole
    return np.where(lam > 1e-3, shape, 0.75 * np.cos(theta) ** 3)


def _hertz_waves(turn: Floats) -> Floats:
    # 3 (sin t - t cos t) / t^3, by its series where that cancels
    t = np.maximum(turn, 0.05)
    closed = 3 * (np.sin(t) - t * np.cos(t)) / t**3
    return np.where(turn > 0.05, closed, 1 - turn**2 / 10 + turn**4 / 280)


def _uniform_waves(turn: Floats) -> Floats:
    from scipy.special import j1  # slow to import

    t = np.maximum(turn, 1e-6)
    return np.where(turn > 1e-6, 2 * j1(t) / t, 1.0)


FLAT_PUNCH = Profile("flat punch", lambda theta, _: np.cos(theta) / 2, waves=lambda turn: np.sinc(turn / np.pi))
"""p = P / (2 pi a sqrt(a^2 - r^2)): a rigid flat end."""
UNIFORM = Profile("uniform", lambda theta, _: 2 / np.pi * np.cos(theta) ** 2, waves=_uniform_waves)
"""p = P / (pi a^2)."""
HERTZ = Profile("hertz", lambda theta, _: 0.75 * np.cos(theta) ** 3, waves=_hertz_waves)
"""p = 3 P sqrt(1 - r^2 / a^2) / (2 pi a^2): a paraboloid."""
ROUND_TIP = Profile("round tip", _sphere_weight, 1.0)
"""A rigid hemisphere at any depth, its contact radius below its own; Hertz' pressure where it is shallow."""


def hertz_radius(force: ArrayLike, tip_radius: float, contact_modulus: float) -> Floats:
    """a = cbrt(3 P R / (4 E*)) [m], 0 where nothing presses. Source: Johnson, eq. (4.22)."""
    pressing = np.maximum(np.asarray(force, dtype=np.float64), 0)
    # roots first: the product of a very small force and a very small radius underflows
    radius: Floats = np.cbrt(pressing) * np.cbrt(0.75 * tip_radius / contact_modulus)
    return radius


def hertz_force(indentation: ArrayLike, tip_radius: float, contact_modulus: float) -> Floats:
    """P = 4/3 E* sqrt(R) delta^1.5 [N], 0 where there is no contact. Source: Johnson, eq. (4.23)."""
    depth = np.maximum(np.asarray(indentation, dtype=np.float64), 0)
    force: Floats = 4 / 3 * contact_modulus * np.sqrt(tip_radius) * depth**1.5
    return force


def hertz_indentation(force: ArrayLike, tip_radius: float, contact_modulus: float) -> Floats:
    """delta = a^2 / R [m] under a force [N]: the inverse of ``hertz_force``."""
    depth: Floats = hertz_radius(force, tip_radius, contact_modulus) ** 2 / tip_radius
    return depth


def punch_force(indentation: ArrayLike, radius: float, contact_modulus: float) -> Floats:
    """P = 2 a E* delta [N] under a rigid flat end. Source: Johnson, eq. (3.36)."""
    force: Floats = 2 * radius * contact_modulus * np.maximum(np.asarray(indentation, dtype=np.float64), 0)
    return force


def round_tip_radius(force: ArrayLike, tip_radius: float, contact_modulus: float) -> Floats:
    """Contact radius a [m] of a rigid hemisphere of radius R: P = E* ((a^2 + R^2) atanh(a / R) - a R).

    Solved for atanh(a / R), which is large for soft bodies and thin needles: 20 mN press a needle of 100 um into rubber
    to its full width, where Hertz' contact would be wider than the needle.

    Raises:
        InputError: a tip radius that is not positive.

    Source: Sneddon (1965), eq. (6.15).
    """
    if not (np.isfinite(tip_radius) and tip_radius > 0):
        raise InputError(f"tip radius {tip_radius} m, a positive length wanted")
    shallow, bend = _round_tip(force, tip_radius, contact_modulus)
    lam = np.where(shallow < 1e-3, shallow, np.tanh(bend))
    radius: Floats = tip_radius * np.minimum(lam, 1.0)
    return radius


def round_tip_indentation(force: ArrayLike, tip_radius: float, contact_modulus: float) -> Floats:
    """Indentation a atanh(a / R) [m] of a rigid hemisphere under a force [N]. Source: as ``round_tip_radius``."""
    shallow, bend = _round_tip(force, tip_radius, contact_modulus)
    depth: Floats = tip_radius * np.where(shallow < 1e-3, shallow**2, np.tanh(bend) * bend)
    return depth


STEPS = 60
"""Most steps, enough for bisection to rounding; five or six of Newton's method are usual."""


def _round_tip(force: ArrayLike, tip_radius: float, contact_modulus: float) -> tuple[Floats, Floats]:
    """Return a / R by Hertz' law, and atanh(a / R)."""
    wanted = np.maximum(np.asarray(force, dtype=np.float64), 0) / contact_modulus / tip_radius**2
    shallow = np.cbrt(0.75 * wanted)
    bends = np.empty(wanted.size)
    _bend(wanted.ravel(), shallow.ravel(), bends)
    return shallow, bends.reshape(wanted.shape)


@kept_njit(error_model="numpy")
def _bend(wanted, shallow, bends):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Solve (lam^2 + 1) bend - lam = wanted, lam = tanh(bend), by Newton's method inside a bracket."""
    for i in range(wanted.size):
        # the root lies below both: P / (E* R^2) >= 4/3 lam^3, and >= atanh(lam) - lam
        low, high = 0.0, wanted[i] + 1
        if shallow[i] < 1:
            high = min(math.atanh(min(shallow[i], 1 - 1e-15)), high)
        bend = high
        for _ in range(STEPS):
            lam = math.tanh(bend)
            off = (lam**2 + 1) * bend - lam - wanted[i]
            low, high = (bend, high) if off < 0 else (low, bend)
            after = bend - off / (2 * lam * (bend * (1 - lam**2) + lam))
            if not low <= after <= high:
                after = (low + high) / 2
            same = abs(after - bend) <= 1e-9 * bend  # the next step is below rounding
            bend = after
            if same:
                break
        bends[i] = bend
