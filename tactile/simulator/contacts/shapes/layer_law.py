"""Law of a round shape on a layer bonded to a rigid base: radius, force, indentation, pressure, and slip."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.elastic.layer_contact import Body, LayerContact, layer_contact
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

By = Literal["force", "indentation"]


@dataclass(frozen=True)
class LayerLaw:
    """A ``body`` of ``radius_`` [m] on the medium's layer; ``shape``: its name in messages.

    Source: ``tactile.elastic.layer_contact``.
    """

    shape: str
    body: Body
    radius_: float
    medium: Medium

    @property
    def law(self) -> LayerContact:
        """The law for a layer of unit thickness."""
        return layer_contact(
            self.body, self.medium.nu, self.radius_ / self.medium.thickness if self.body == "sphere" else 1.0
        )

    @property
    def profile(self) -> Profile:
        """The pressure; its lam is the contact radius over the thickness."""
        return self.law.profile

    @property
    def _units(self) -> dict[By, float]:
        """Units of force [N] and indentation [m] in the tables."""
        h, stiff = self.medium.thickness, self.medium.contact_modulus
        if self.body == "paraboloid":
            return {"force": stiff * h**3 / self.radius_, "indentation": h**2 / self.radius_}
        return {"force": stiff * h**2, "indentation": h}

    def radius(self, force: Floats) -> Floats:
        """Return the contact radius [m] under normal forces [N].

        Raises:
            InputError: forces that press the body through the layer, or a contact beyond the tables.
        """
        wide = self._inverse(force, "force")
        self._check_through(self.law.indentation(wide) * self._units["indentation"], force)
        return wide * self.medium.thickness

    def force_on(self, radius: Floats) -> Floats:
        """Return the normal force [N] at a contact radius [m]; of a flat punch, at 1 m of indentation.

        Raises:
            InputError: a contact beyond the tables.
        """
        wide = radius / self.medium.thickness
        if (wide > self.law.widest).any():
            raise InputError(
                f"{self._named}: a contact {np.max(radius) * 1e3:.4g} mm in radius; at most "
                f"{self.law.widest * self.medium.thickness * 1e3:.4g} mm wanted, {self._end}"
            )
        units = self._units
        return self.law.force(wide) * units["force"] / (units["indentation"] if self.body == "flat" else 1.0)

    def force(self, indentation: Floats) -> Floats:
        """Return the normal force [N] at indentations [m], 0 where there is no contact.

        Raises:
            InputError: an indentation as deep as the layer is thick, or a contact beyond the tables.
        """
        deep, units = np.maximum(indentation, 0), self._units
        self._check_through(deep)
        if self.body == "flat":
            return np.asarray(self.law.force(self._punch()) * units["force"] * deep / units["indentation"])
        return np.asarray(self.law.force(self._inverse(deep, "indentation")) * units["force"])

    def indentation(self, force: Floats) -> Floats:
        """Return the indentation [m] under normal forces [N]: the inverse of ``force``.

        Raises:
            InputError: as ``radius``.
        """
        units = self._units
        if self.body == "flat":
            deep = force / (self.law.force(self._punch()) * units["force"]) * units["indentation"]
        else:
            deep = self.law.indentation(self._inverse(force, "force")) * units["indentation"]
        self._check_through(deep, force)
        return np.asarray(deep)

    def stuck_circles(self, contact: Floats, share: Floats) -> tuple[Floats, Floats, Profile]:
        """Return the radius [m] of the circle that sticks, the share of it spread like a pressure, the rest's profile.

        Arguments: ``contact``: radius [m]; ``share`` of the force that the circle carries, see ``layer_slip``.
        """
        from tactile.elastic.layer_slip import layer_slip  # tables that only friction needs

        slip = layer_slip(self.law)
        wide = contact / self.medium.thickness
        return slip.radius(wide, share) * self.medium.thickness, slip.pressed(wide, share), slip.profile

    def carried_over(self, ends: Floats, shares: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Return friction's rings (n, k) and their shares (n, k, 2) after a change of the normal force.

        A ring keeps its place and its traction; rings outside the new contact vanish. On the half-space it then keeps
        the force within, too; on a layer the pressure there changes with the whole contact's.

        Arguments: ``force`` (n,) [N] after the change; rings end at the force before it, or at 0 beyond the last.
        """
        from tactile.elastic.layer_slip import layer_slip  # the same

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

    def _inverse(self, values: Floats, by: By) -> Floats:
        """Return the contact radius in thicknesses at forces [N] or indentations [m]."""
        unit = self._units[by]
        aim = np.maximum(np.asarray(values, dtype=np.float64), 0) / unit
        most, limit = float(aim.max(initial=0)), self.law.most(by)
        if most > limit:
            size, of = (unit, "N") if by == "force" else (unit * 1e3, "mm deep")
            raise InputError(
                f"{self._named}: {most * size:.4g} {of}; at most {limit * size:.4g} {of} wanted, {self._end}"
            )
        return self.law.radius_of(aim, by)

    def _punch(self) -> Floats:
        """Return a flat end's radius in thicknesses."""
        wide = self.radius_ / self.medium.thickness
        if wide > self.law.widest:
            raise InputError(f"{self._named}, at most {self.law.widest:g} thicknesses wanted")
        return np.asarray(wide)

    @property
    def _named(self) -> str:
        name = self.shape.replace("_", " ")
        return f"a {name} of radius {self.radius_ * 1e3:g} mm on a cover of {self.medium.thickness * 1e3:g} mm"

    @property
    def _end(self) -> str:
        """The reason why the tables end."""
        if self.law.ends_at_own_radius:
            return f"where its contact is as wide as the {self.shape} itself"
        return f"where its contact is {self.law.widest:.4g} thicknesses in radius"

    def _check_through(self, deep: Floats, force: Floats | None = None) -> None:
        most, h = float(np.max(deep, initial=0)), self.medium.thickness
        if most >= h:
            by = "" if force is None else f" under {float(np.max(force, initial=0)):.4g} N"
            raise InputError(
                f"a {self.shape} of radius {self.radius_ * 1e3:g} mm sinks {most * 1e3:.4g} mm{by} into a cover of "
                f"{h * 1e3:g} mm; less than its thickness wanted"
            )
