"""Reading under a unit force over a circle as six functions of distance and radius, on half-space and layer.

With c = cos, s = sin of the azimuth of the taxel seen from the circle and A = Q c + R s, a load (Q, R, F) and a twist M
give

    zz: F g[ZZ] - A g[ZR]
    xz: -F c g[RZ] + Q g[EVEN] - (2 c A - Q) g[ODD] + M s g[TWIST],    yz alike with s, R and -M c

Lengths are counted in depths of the taxel, forces in units of 1 / (the medium's reading).
"""

from collections.abc import Callable

import numpy as np
from scipy.special import j0, j1

from cnnsim.support import Floats
from tactile.elastic.discs import potential
from tactile.elastic.gauss import gauss, panels
from tactile.elastic.layer import transfer
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

ZZ, ZR, RZ, EVEN, ODD, TWIST = range(6)
Weight = Callable[[Floats, Floats], Floats]
PANEL = 14.0
"""Phase of the fastest wave over one panel of 16 Gauss nodes: good to 1e-10."""
SMOOTHED = 12.0
"""Wavenumber times thickness at which a turned part is smoothed: its rim is singular, the stuck area no circle."""
TURNED_REACH = 14.0
"""Thicknesses from a circle beyond which the field of a turned part is 0: exp(-pi / 2 14) is 3e-10."""
PANEL_WIDTH = 2.5
"""Largest width of a panel, as a wavenumber times the thickness: transfer functions have poles near the real axis at
about 2, so that wider panels lose digits, 1e-5 at 14."""


def half_space(rho: Floats, radius: Floats, profile: Profile, lam: Floats, trace: float) -> Floats:
    """Return the six functions (radii, distances, 6) on the half-space.

    Arguments: ``rho`` (distances,), ``radius`` and ``lam`` (radii,); ``trace`` of ``halfspace.point_scale``. The
    traction of the twist is -1/2 of the slope of the profile's pressure.

    Source: ``discs``, written by the azimuth.
    """
    grown = np.broadcast_to(rho, (len(radius), len(rho)))
    a, b, c, h = potential(grown, radius[:, None], profile, lam[:, None], True)
    bend = rho**2 * h / 2
    return np.stack(
        [b + 2 * a + 2 * bend - trace * b, rho * (c + trace * a), rho * c, b - a - bend, bend, rho * c / 2], axis=-1
    )


def layer(
    rho: Floats, radius: Floats, profile: Profile, lam: Floats, medium: Medium, depth: float, fall: float = 46.0
) -> Floats:
    """Return the layer's share of the six functions (radii, distances, 6): layer minus half-space.

    The integral over the waves k of k N(k) w(k a) J_m(k rho) / 2 pi, where N is the difference of the transfer
    functions and w the transform of the profile, w(k) = integral of its line weight times cos(k sin(theta)). The
    profile's ``turned`` part is added as a whole, smoothed over a thickness over ``SMOOTHED``.

    Arguments: ``depth`` of the taxel over the layer's thickness; ``rho``, ``radius`` in thicknesses here; ``fall``: the
    waves end where the difference, which falls off like exp(-k (2 - depth)), has fallen by exp(-fall).

    Source: Sneddon, Fourier Transforms (1951), ch. 10, for layers under axisymmetric loads.
    """
    unit = Medium(1.0, medium.nu, medium.quantity)
    k, step = _waves(fall / (2 - depth), rho, radius)
    bonded, endless = transfer(k, depth, 1.0, unit), transfer(k, depth, np.inf, unit)
    zz, zr, rz, shear, across = (
        (getattr(bonded, name) - getattr(endless, name)) * step
        for name in ("normal", "normal_shear", "shear_normal", "shear", "across")
    )
    zeroth, first, second = _bessel(k, rho)
    spread = profile_waves(k, radius, profile.weight, lam, profile.waves)
    columns = (
        (zeroth, zz), (first, zr), (first, rz), (zeroth, (shear + across) / 2),
        (second, (shear - across) / 2), (first, -k * across / 2),
    )  # fmt: skip
    out = np.stack([(spread * part) @ wave.T for wave, part in columns], axis=-1)
    if profile.turned is not None:
        # along (cos 2 phi, sin 2 phi) waves of one azimuth turn into those of another: even and odd change places
        near = rho < radius.max() + TURNED_REACH
        k, step = _waves(min(fall / depth, SMOOTHED * np.sqrt(fall)), np.append(rho[near], 0), radius)
        bonded = transfer(k, depth, 1.0, unit)
        zeroth, first, second = _bessel(k, rho[near])
        spread = profile_waves(k, radius, profile.turned, lam) * (step * np.exp(-((k / SMOOTHED) ** 2)))
        spread[radius == 0] = 0
        out[:, near, ZR] += (spread * bonded.normal_shear) @ first.T
        out[:, near, EVEN] += (spread * (bonded.shear - bonded.across) / 2) @ zeroth.T
        out[:, near, ODD] += (spread * (bonded.shear + bonded.across) / 2) @ second.T
    return out


def _waves(top: float, rho: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Return wavenumbers from 0 to ``top``, and k dk / 2 pi."""
    widest = float(rho.max() + radius.max())
    k, weights = panels(top, int(np.ceil(top * max(widest / PANEL, 1 / PANEL_WIDTH))))
    return k, k * weights / (2 * np.pi)


def _bessel(k: Floats, rho: Floats) -> tuple[Floats, Floats, Floats]:
    """Return J0, J1 and J2 of k rho, (distances, waves)."""
    phase = k * rho[:, None]
    zeroth, first = j0(phase), j1(phase)
    return zeroth, first, np.where(phase > 1e-3, 2 * first / np.maximum(phase, 1e-3) - zeroth, phase**2 / 8)


def profile_waves(
    k: Floats, radius: Floats, weight: Weight, lam: Floats, closed: Callable[[Floats], Floats] | None = None
) -> Floats:
    """Return the Hankel transform (radii, waves) of a profile over circles, in closed form or from its weight."""
    if closed is not None:
        return closed(np.multiply.outer(radius, k))
    out = np.empty((len(radius), len(k)))
    for row, a, shape in zip(out, radius.tolist(), lam.tolist(), strict=True):
        if a == 0:
            row[:] = 1
            continue
        # the fastest wave turns k a / 2 times over the quarter circle
        nodes, weights = gauss(20 + int(0.7 * float(k[-1]) * a))
        theta = (nodes + 1) * np.pi / 4
        row[:] = np.cos(np.outer(k, a * np.sin(theta))) @ (
            weights * np.pi / 2 * weight(theta, np.full(len(theta), shape))
        )
    return out
