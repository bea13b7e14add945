"""Law of the tip over a contact at a point on a layer: its stiffness, and the circle over which it spreads the force.

A point may press with any force: beyond its tables the law is extrapolated as a power. The law of a body is refused
there.
"""

from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from cnnsim.support import Floats
from tactile.elastic.layer_contact import layer_contact
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import ROUND_TIP, Profile, round_tip_radius

THINNEST = 1e-4
"""Contact radius, over the widest in the tables, below which a layer is a half-space: its force is off by 0.3 %."""
STEPS = 4
"""Steps of Newton's method from the nearest places of the table to rounding."""
SMALL = 0.25
"""Largest tip radius over thickness at which circles are those of the half-space: fields differ by at most 4e-4."""


@lru_cache(maxsize=16)
def _stiffer(nu: float) -> CubicSpline:
    """Logarithm of the force under a paraboloid over the half-space's by that of the indentation, R = h = E* = 1."""
    law = layer_contact("paraboloid", nu)
    radii = law.widest * np.geomspace(THINNEST, 1, 160)
    deep = law.indentation(radii)
    return CubicSpline(np.log(deep), np.log(law.force(radii) / (4 / 3 * deep**1.5)))


def _force(deep: Floats, law: CubicSpline) -> tuple[Floats, Floats]:
    """Logarithm of the force and its slope by that of the indentation; past the tables a power of it."""
    inside = np.clip(deep, law.x[0], law.x[-1])
    slope = np.where(deep < law.x[0], 0.0, law(inside, 1))
    more = law(inside) + slope * (deep - inside)
    return np.log(4 / 3) + 1.5 * deep + more, 1.5 + slope


def held_factor(force: Floats, rise: Floats, radius: float, medium: Medium) -> Floats:
    """Return the growth of normal forces [N] under a tip of a ``radius`` [m] when a layer rises by ``rise`` [m].

    The tip is a paraboloid, as Hertz has it. Forces that do not press are unchanged.
    """
    law, h = _stiffer(medium.nu), medium.thickness
    pressing = force > 0
    wanted = np.log(np.where(pressing, force, 1.0) * radius / (medium.contact_modulus * h**3))
    known = _force(law.x, law)[0]
    deep = np.interp(wanted, known, law.x)
    for _ in range(STEPS):
        got, slope = _force(deep, law)
        deep = deep + (wanted - got) / slope
    deeper = np.exp(deep) + rise * radius / h**2
    touches = pressing & (deeper > 0)
    grown = _force(np.log(np.where(touches, deeper, 1.0)), law)[0] - _force(deep, law)[0]
    factor: Floats = np.where(touches, np.exp(np.where(touches, grown, 0.0)), np.where(pressing, 0.0, 1.0))
    return factor


def circle(force: Floats, radius: float, medium: Medium) -> tuple[Floats, Profile, float]:
    """Return the contact radii [m] of a hemisphere under forces [N], their pressure, and the unit [m] of its lam.

    On a layer a contact is narrower than on the half-space, and no wider than the tip itself on either.
    """
    h = medium.thickness
    if radius <= SMALL * h:
        return round_tip_radius(force, radius, medium.contact_modulus), ROUND_TIP, radius
    law = layer_contact("sphere", medium.nu, radius / h)
    aim = np.clip(force / (medium.contact_modulus * h**2), 0.0, law.most("force"))
    return law.radius_of(aim, "force") * h, law.profile, h
