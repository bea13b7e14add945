"""Dimensions and outline of the bump, and the size of its elements."""

import itertools
from dataclasses import dataclass
from functools import partial

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from tactile.bump.triangulate import Side, straight


@dataclass(frozen=True)
class Shape:
    """A hemisphere on a body whose bottom is fixed and whose sides are free, in the plane (x or radius, z), z down.

    Arguments, all [m]: ``radius`` R of the hemisphere; ``thickness`` of the body under it; ``reach``: half the body's
    width, or its radius; ``contact``: half the width of the top that sticks to the rigid plate, along x; ``fillet``:
    height and width of the element inclined at 45 degrees in the corner between hemisphere and body. The paper gives
    neither of the last two.

    Raises:
        InputError: a length that is not positive, a body narrower than the bump, a contact or fillet as large as it.

    Source: Vasarhelyi, Fodor, Roska, sect. 5.
    """

    radius: float = 0.2e-3
    thickness: float = 2e-3
    reach: float = 2e-3
    contact: float = 0.1e-3
    fillet: float = 0.02e-3

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"a bump with {name} {value} m, a positive length wanted")
        if self.contact >= 0.95 * self.radius or self.fillet > 0.5 * self.radius:
            raise InputError(
                f"a bump of radius {self.radius} m with a contact of {self.contact} m and a fillet of {self.fillet} m, "
                "a contact below 0.95 and a fillet up to 0.5 of the radius wanted"
            )
        if self.reach < 1.2 * self.foot:
            raise InputError(
                f"a body {self.reach} m to each side of a bump of {self.foot} m, at least 1.2 of it wanted"
            )

    @property
    def waist(self) -> float:
        """Half-width where hemisphere and fillet meet."""
        return float(np.sqrt(self.radius**2 - self.fillet**2))

    @property
    def foot(self) -> float:
        """Half-width where the fillet meets the body's surface."""
        return self.waist + self.fillet

    def outline(self) -> list[Side]:
        """Return the boundary of the half x >= 0 as sides that join at its corners, the axis last."""
        edge, waist = np.arcsin(self.contact / self.radius), np.arccos(self.fillet / self.radius)

        def arc(start: float, stop: float, share: Floats) -> Floats:
            angle = start + (stop - start) * share
            return self.radius * np.stack([np.sin(angle), -np.cos(angle)], axis=-1)

        corners = [(self.foot, 0.0), (self.reach, 0.0), (self.reach, self.thickness), (0.0, self.thickness)]
        lines = [((self.waist, -self.fillet), corners[0]), *itertools.pairwise(corners)]
        return [
            partial(arc, 0.0, edge),
            partial(arc, edge, waist),
            *(straight(start, stop) for start, stop in (*lines, (corners[-1], (0.0, -self.radius)))),
        ]

    def inside(self, points: Floats) -> Flags:
        """Return which points (n, 2) lie inside the half x >= 0."""
        x, z = points.T
        body = (x > 0) & (x < self.reach) & (z >= 0) & (z < self.thickness)
        cap = (x > 0) & (z < 0) & (np.hypot(x, z) < self.radius)
        corner = (z < 0) & (z > -self.fillet) & (x > 0) & (x < self.foot + z)
        return np.asarray(body | cap | corner)

    def size(
        self, points: Floats, fineness: float = 1.0, touching: bool = False, sensor: float | None = None
    ) -> Floats:
        """Return the wanted edge length [m]: small where stress peaks, at the contact's edge and in the bump's corner.

        With ``touching`` small all along the arc that a plate may touch. With ``sensor``, a depth [m] on the axis where
        strains are read, small there, and still smaller where stress is singular: at the end of the stuck top, at both
        ends of the fillet, and where the free side meets the fixed bottom.
        """
        edge, foot = np.array([self.contact, -np.sqrt(self.radius**2 - self.contact**2)]), np.array([self.foot, 0.0])
        fine = [(edge, 0.01), (foot, 0.05)]  # and how fine, in radii
        largest = self.thickness / 4
        if touching:
            angle = np.clip(np.arctan2(points[:, 0], -points[:, 1]), 0, 1.0)
            fine[0] = self.radius * np.stack([np.sin(angle), -np.cos(angle)], axis=-1), 0.025
        elif sensor is not None:
            waist, bottom = np.array([self.waist, -self.fillet]), np.array([self.reach, self.thickness])
            fine = [(edge, 0.0002), (waist, 0.002), (foot, 0.002), (bottom, 0.05), (np.array([0.0, sensor]), 0.005)]
            largest = self.thickness / 12
        wanted = [at * self.radius + 0.2 * np.linalg.norm(points - place, axis=-1) for place, at in fine]
        return np.asarray(np.minimum(np.min(wanted, axis=0), largest) / fineness)

    def curved(self, points: Floats) -> Flags:
        """Return which points (n, 2) lie on the hemisphere's arc."""
        on = np.abs(np.hypot(*points.T) - self.radius) < 1e-9 * self.radius
        return np.asarray(on & (points[:, 1] < -self.fillet * (1 - 1e-9)))
