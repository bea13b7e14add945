"""Interface of a shape of indenters: ``IndenterShape``, ``RoundShape`` with a circular contact, ``LineShape``."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import Profile

if TYPE_CHECKING:
    from tactile.elastic.adhesion import AdhesionLaw
    from tactile.elastic.layer_contact import Body
    from tactile.simulator.contacts.friction import Carry
    from tactile.simulator.contacts.shapes.layer_law import LayerLaw


@dataclass(frozen=True)
class IndenterShape:
    """A rigid body: ``radius`` [m], ``length`` [m] and ``angle`` [rad, from x towards y], 0 where it has none.

    ``needs``: sizes that have to be positive; ``has_law``: its force follows from its indentation; ``curved``: a curved
    cover changes its radius at the contact; ``by_tip``: it is held by the tip of a mounting, for want of a radius.
    """

    radius: float = 0.0
    length: float = 0.0
    angle: float = 0.0
    name: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    has_law: ClassVar[bool] = False
    curved: ClassVar[bool] = False
    by_tip: ClassVar[bool] = False

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the indentation [m] under normal forces [N], 0 where nothing presses.

        Raises:
            InputError: a shape without a size; on a layer, forces that press the body through it.
        """
        raise InputError(f"the indentation of a {self.name}, which has no size; another shape wanted")

    def force_at(self, indentation: Floats, medium: Medium) -> Floats:
        """Return the normal force [N] at an indentation [m].

        Raises:
            InputError: a shape without such a law; an indentation as deep as the layer is thick.
        """
        raise InputError(f"an indentation given for a {self.name}, a sphere, needle or flat_punch wanted")

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Return the factor by which the force of a body held at its height grows when the cover rises by ``rise`` [m].

        Arguments: ``tip_radius`` [m] of the mounting, the radius of shapes that have none. What does not press (force 0
        or pulling) keeps its force.
        """
        return growth(force, self.force_at(self.indentation(force, medium) + rise, medium))


@dataclass(frozen=True)
class LineShape(IndenterShape):
    """A shape that presses along a line."""

    needs: ClassVar[tuple[str, ...]] = ("length",)

    def points(self, total: Floats, depth: float, medium: Medium) -> Floats:
        """Return the point loads (frames, n, 5) of total loads (frames, 5), for taxels at ``depth`` [m].

        Raises:
            InputError: on a layer, forces that press it through; taxels so shallow that it takes too many points.
        """
        raise NotImplementedError


def growth(force: Floats, new: Floats) -> Floats:
    """Return new over old force, 1 where nothing presses."""
    pressing = force > 0
    out: Floats = np.where(pressing, new / np.where(pressing, force, 1.0), 1.0)
    return out


@dataclass(frozen=True)
class RoundShape(IndenterShape):
    """A shape whose contact is a circle.

    ``pressure`` on the half-space; ``on_layer``: the body of ``layer_contact`` that gives its law on a layer. A shape
    with a law defines the four functions of it on the half-space.
    """

    needs: ClassVar[tuple[str, ...]] = ("radius",)
    pressure: ClassVar[Profile]
    on_layer: ClassVar["Body | None"] = None

    def radius_at_force(self, force: Floats, stiff: float) -> Floats:
        """Return the contact radius [m] on a half-space of a contact modulus ``stiff`` [Pa]."""
        return np.full(np.shape(force), self.radius)

    def force_at_indentation(self, indentation: Floats, stiff: float) -> Floats:
        """Return the force [N] on a half-space."""
        raise NotImplementedError

    def force_at_radius(self, radius: Floats, stiff: float) -> Floats:
        """Return the force [N] on a half-space at a contact radius [m]."""
        raise NotImplementedError

    def indentation_at_force(self, force: Floats, stiff: float) -> Floats:
        """Return the indentation [m] on a half-space."""
        raise NotImplementedError

    def layer_law(self, medium: Medium) -> "LayerLaw | None":
        """Return the law on the medium's layer, None on a half-space or where the shape has no law."""
        if np.isinf(medium.thickness) or self.on_layer is None:
            return None
        from tactile.simulator.contacts.shapes.layer_law import LayerLaw  # imports SciPy's splines

        return LayerLaw(self.name, self.on_layer, self.radius, medium)

    def contact_radius(self, force: Floats, medium: Medium) -> Floats:
        """Return the radius a [m] of the contact under normal forces [N].

        Raises:
            InputError: on a layer, forces that press the body through it.
        """
        law = self.layer_law(medium)
        return self.radius_at_force(force, medium.contact_modulus) if law is None else law.radius(force)

    def force_at(self, indentation: Floats, medium: Medium) -> Floats:
        """Return the normal force [N] at an indentation [m]: see ``IndenterShape.force_at``."""
        if not self.has_law:
            return super().force_at(indentation, medium)
        law = self.layer_law(medium)
        return self.force_at_indentation(indentation, medium.contact_modulus) if law is None else law.force(indentation)

    def force_on(self, radius: Floats, medium: Medium) -> Floats:
        """Return the normal force [N] at a contact radius [m].

        Raises:
            InputError: on a layer, a contact beyond the tables.
        """
        law = self.layer_law(medium)
        return self.force_at_radius(radius, medium.contact_modulus) if law is None else law.force_on(radius)

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the indentation [m] under normal forces [N]: see ``IndenterShape.indentation``."""
        pressing, law = np.maximum(force, 0), self.layer_law(medium)
        return self.indentation_at_force(pressing, medium.contact_modulus) if law is None else law.indentation(pressing)

    def profile(self, medium: Medium) -> tuple[Profile, float]:
        """Return the pressure, and the length [m] by which contact radii are divided for the profile's ``lam``."""
        law = self.layer_law(medium)
        if law is not None:
            return law.profile, medium.thickness
        return self.pressure, self.radius if np.isfinite(self.pressure.limit) else np.inf

    def stuck_circles(self, force: Floats, stuck: Floats, medium: Medium) -> tuple[Floats, Floats, Profile] | None:
        """Return the reduction of the shear in the sticking circle, None where it is the pressure under ``stuck`` [N].

        Returns the radii [m] of the circles, the share of the reduction that is distributed like the pressure, and the
        profile of the rest. Only on a layer the reduction is not a pressure. Source: ``tactile.elastic.layer_slip``.
        """
        law = self.layer_law(medium)
        return None if law is None else law.stuck_circles(law.radius(force), stuck / np.where(force > 0, force, 1.0))

    def carrying(self, medium: Medium) -> "Carry | None":
        """Return the change of friction's rings with the normal force, None without a change: see ``LayerLaw``."""
        law = self.layer_law(medium)
        return None if law is None else law.carried_over

    def adhesion(self, medium: Medium, work: float, most: float, by_depth: bool) -> "AdhesionLaw":
        """Return the law of the adhering body: see ``tactile.elastic.adhesion``."""
        from tactile.elastic.adhesion import adhesion
        from tactile.simulator.contacts.shapes.flat_punch import FlatPunch

        return adhesion(self, FlatPunch(self.radius), medium, work, most, by_depth)
