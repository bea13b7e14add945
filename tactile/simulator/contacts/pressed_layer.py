"""Round indenters on a cover of finite thickness: radius, force and indentation, refused beyond their range."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.elastic.layer_contact import Body, LayerContact, layer_contact
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

BODIES: dict[str, Body] = {"sphere": "paraboloid", "needle": "sphere", "flat_punch": "flat"}


@dataclass(frozen=True)
class PressedLayer:
    """A sphere (as a paraboloid, like Hertz), needle or flat punch of ``radius`` [m] on the medium's layer.

    Source: ``tactile.elastic.layer_contact``.
    """

    shape: str
    radius_: float
    medium: Medium

    @property
    def law(self) -> LayerContact:
        """The law for a layer of unit thickness."""
        size = self.radius_ / self.medium.thickness if self.shape == "needle" else 1.0
        return layer_contact(BODIES[self.shape], self.medium.nu, size)

    @property
    def profile(self) -> Profile:
        """The pressure; its lam is the contact radius over the thickness."""
        return self.law.profile

    def sticking(self, contact: Floats, share: Floats) -> tuple[Floats, Floats, Profile]:
        """Radius [m] of the circle that sticks, and of what is taken off the tractions of sliding there two shapes.

        The share that is spread like the pressure of a contact as wide as that circle, and the profile of the rest.

        Arguments: ``contact``: radius [m]; ``share`` of the force that this carries, see ``layer_slip``.
        """
        from tactile.elastic.layer_slip import layer_slip  # only where friction asks for it

        slip = layer_slip(self.law)
        wide = contact / self.medium.thickness
        return slip.radius(wide, share) * self.medium.thickness, slip.pressed(wide, share), slip.profile

    def carried_over(self, ends: Floats, shares: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Rings of friction (n, k) and their shares (n, k, 2), as of `FrictionState`, once the normal force is another.

        A ring keeps its place and its traction, but for what the contact has left. Only on the half-space does it then
        also keep the force within: on a layer the pressure there grows or falls with all that presses around it.

        Arguments: ``force`` (n,) [N] that presses now; rings end at that of before, or at 0 beyond the last.
        """
        from tactile.elastic.layer_slip import layer_slip  # only where friction asks for it

        slip, h = layer_slip(self.law), self.medium.thickness
        before = ends.max(axis=1, keepdims=True)
        kept = (before[:, 0] > 0) & (force > 0) & (before[:, 0] != force)
        ends, shares = ends.copy(), shares.copy()
        if not kept.any():
            return ends, shares
        old, now = before[kept], force[kept, None]
        rings = np.where(ends[kept] > 0, ends[kept], old)  # beyond the last there is nothing
        was, wide = self.radius(old) / h, self.radius(now) / h
        circle = np.minimum(slip.radius(was, rings / old), wide)
        within = np.diff(old * np.where(circle < was, slip.share(was, circle), 1), axis=1, prepend=0)
        after = now * np.where(circle < wide, slip.share(wide, circle), 1)
        room = np.diff(after, axis=1, prepend=0)
        share = shares[kept] * np.where(room > 0, within / np.where(room > 0, room, 1), 0)[..., None]
        ends[kept] = np.where(ends[kept] > 0, after, 0)
        shares[kept] = share / np.maximum(np.hypot(share[..., 0], share[..., 1]), 1)[..., None]
        return ends, shares

    @property
    def _units(self) -> tuple[float, float]:
        """Of force [N] and indentation [m] in the tables."""
        h, stiff = self.medium.thickness, self.medium.contact_modulus
        if self.shape == "sphere":
            return stiff * h**3 / self.radius_, h**2 / self.radius_
        return stiff * h**2, h

    def radius(self, force: Floats) -> Floats:
        """Contact radius [m] under normal forces [N].

        Raises:
            InputError: forces that press the body through the layer, or a contact beyond the tables.
        """
        h = self.medium.thickness
        if self.shape == "flat_punch":
            return np.full(np.shape(force), self.radius_)
        wide = self._turned(force, "force")
        deep = self.law.indentation(wide) * self._units[1]
        self._check(deep, float(np.max(force, initial=0)))
        return wide * h

    def force_on(self, radius: Floats) -> Floats:
        """Normal force [N] with which the contact is so wide [m]; of a flat punch, at 1 m of indentation.

        Raises:
            InputError: a contact beyond the tables.
        """
        wide, (force_unit, depth_unit) = radius / self.medium.thickness, self._units
        if (wide > self.law.widest).any():
            raise InputError(
                f"{self._named}: a contact {np.max(radius) * 1e3:.4g} mm in radius; at most "
                f"{self.law.widest * self.medium.thickness * 1e3:.4g} mm wanted, {self._end}"
            )
        return self.law.force(wide) * force_unit / (depth_unit if self.shape == "flat_punch" else 1.0)

    def force(self, indentation: Floats) -> Floats:
        """Normal force [N] at indentations [m], 0 where there is no contact.

        Raises:
            InputError: an indentation as deep as the layer is thick, or a contact beyond the tables.
        """
        deep = np.maximum(indentation, 0)
        self._check(deep, None)
        force_unit, depth_unit = self._units
        if self.shape == "flat_punch":
            wide = np.asarray(self._punch())
            return np.asarray(self.law.force(wide) * force_unit * deep / depth_unit)
        return np.asarray(self.law.force(self._turned(deep, "indentation")) * force_unit)

    def indentation(self, force: Floats) -> Floats:
        """Indentation [m] under normal forces [N]: the inverse of ``force``.

        Raises:
            InputError: as ``radius``.
        """
        force_unit, depth_unit = self._units
        if self.shape == "flat_punch":
            deep = force / (self.law.force(np.asarray(self._punch())) * force_unit) * depth_unit
        else:
            deep = self.law.indentation(self._turned(force, "force")) * depth_unit
        self._check(deep, float(np.max(force, initial=0)))
        return np.asarray(deep)

    def _turned(self, wanted: Floats, by: Literal["force", "indentation"]) -> Floats:
        unit = self._units[0 if by == "force" else 1]
        aim = np.maximum(np.asarray(wanted, dtype=np.float64), 0) / unit
        most, limit = float(aim.max(initial=0)), self.law.most(by)
        if most > limit:
            size, of = (unit, "N") if by == "force" else (unit * 1e3, "mm deep")
            raise InputError(
                f"{self._named}: {most * size:.4g} {of}; at most {limit * size:.4g} {of} wanted, {self._end}"
            )
        return self.law.radius_of(aim, by)

    @property
    def _named(self) -> str:
        return f"a {self.shape} of radius {self.radius_ * 1e3:g} mm on a cover of {self.medium.thickness * 1e3:g} mm"

    @property
    def _end(self) -> str:
        """What ends the tables."""
        if self.shape == "needle" and self.law.nears_its_own:
            return "where its contact is as wide as the needle itself"
        return f"where its contact is {self.law.widest:.4g} thicknesses in radius"

    def _punch(self) -> float:
        wide = self.radius_ / self.medium.thickness
        if wide > self.law.widest:
            raise InputError(
                f"a flat punch of radius {self.radius_ * 1e3:g} mm on a cover of {self.medium.thickness * 1e3:g} mm, "
                f"at most {self.law.widest:g} thicknesses wanted"
            )
        return wide

    def _check(self, deep: Floats, force: float | None) -> None:
        most, h = float(np.max(deep, initial=0)), self.medium.thickness
        if most >= h:
            by = "" if force is None else f" under {force:.4g} N"
            raise InputError(
                f"a {self.shape} of radius {self.radius_ * 1e3:g} mm sinks {most * 1e3:.4g} mm{by} into a cover of "
                f"{h * 1e3:g} mm; less than its thickness wanted"
            )
