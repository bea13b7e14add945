"""Adhesion of a rigid round body by Johnson, Kendall and Roberts: a contact that pulls until it snaps off."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.medium import Medium

POINTS = 4000
"""Contact radii in a table; interpolated forces are off by less than 1e-6."""


class DryLaw(Protocol):
    """The laws of the same body without adhesion."""

    def contact_radius(self, force: Floats, medium: Medium) -> Floats: ...  # noqa: D102 - [m] at a force [N]
    def force_on(self, radius: Floats, medium: Medium) -> Floats: ...  # noqa: D102 - [N] at a radius [m]
    def indentation(self, force: Floats, medium: Medium) -> Floats: ...  # noqa: D102 - [m] at a force [N]


@dataclass(frozen=True)
class AdhesionLaw:
    """Law of an adhering body by its contact radius: ``force`` [N] = ``pressed`` - ``pulled``, ``indentation`` [m].

    ``pressed`` is the force of the dry body at this radius, ``pulled`` that of a flat punch held by the surface
    energy w: pulled^2 = 4 pi a w / (-dC / da) with C(a) the compliance of a flat punch, 8 pi E* w a^3 on the
    half-space. All grow from the first row to the last; the first is where it snaps off.
    """

    radius: Floats
    force: Floats
    pressed: Floats
    indentation: Floats

    def at(self, wanted: Floats, by_depth: bool) -> tuple[Floats, Floats]:
        """Return (force, pressed) at a force or an indentation, not below that of the first row."""
        known = self.indentation if by_depth else self.force
        return np.interp(wanted, known, self.force), np.interp(wanted, known, self.pressed)


def adhesion(body: DryLaw, punch: DryLaw, medium: Medium, work: float, most: float, by_depth: bool) -> AdhesionLaw:
    """Return the table for forces up to about ``most`` [N] and a work of adhesion w [J/m^2].

    Arguments: ``punch``: a flat punch whose ``force_on`` gives its force [N] at 1 m of indentation; ``by_depth``: the
    indentation is prescribed, so that the contact snaps off at its minimum, not at that of the force.

    Source: Johnson, Kendall, Roberts (1971); Maugis, Contact, Adhesion and Rupture of Elastic Solids, ch. 4; with the
    layer's compliance Yang (2002).
    """
    # increase the radius until its force exceeds the largest
    size = float(body.contact_radius(np.array([max(most, 1e-12)]), medium)[0])
    for _ in range(60):
        if float(body.force_on(np.array([size]), medium)[0] - _pulled(np.array([size]), punch, medium, work)[0]) > most:
            break
        size *= 1.25
    radius = np.linspace(size / POINTS, size, POINTS)
    pressed, pulled = body.force_on(radius, medium), _pulled(radius, punch, medium, work)
    force = pressed - pulled
    depth = body.indentation(pressed, medium) - pulled / punch.force_on(radius, medium)
    first = int(np.argmin(depth if by_depth else force))
    return AdhesionLaw(radius[first:], force[first:], pressed[first:], depth[first:])


def flat_adhesion(radius: float, punch: DryLaw, medium: Medium, work: float, most: float) -> AdhesionLaw:
    """Return the table for a flat punch, whose contact keeps its width until it snaps off."""
    edge = np.array([radius])
    force = np.linspace(-_pulled(edge, punch, medium, work)[0], max(most, 1e-12), 2)
    return AdhesionLaw(np.full(2, radius), force, force, force / punch.force_on(edge, medium))


def _pulled(radius: Floats, punch: DryLaw, medium: Medium, work: float) -> Floats:
    step = 1e-4 * radius
    low, high = punch.force_on(radius - step, medium), punch.force_on(radius + step, medium)
    slope = (1 / low - 1 / high) / (2 * step)
    pulled: Floats = np.sqrt(4 * np.pi * radius * work / slope)
    return pulled
