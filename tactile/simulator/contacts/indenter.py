"""Indenters: the contact radius under a force, the pressure profile and the force law of each shape."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import (
    FLAT_PUNCH,
    HERTZ,
    ROUND_TIP,
    UNIFORM,
    Profile,
    hertz_force,
    hertz_indentation,
    hertz_radius,
    punch_force,
    round_tip_indentation,
    round_tip_radius,
)

if TYPE_CHECKING:
    from tactile.simulator.contacts.friction import Carry
    from tactile.simulator.contacts.pressed_layer import PressedLayer

ShapeName = Literal["point", "disc", "flat_punch", "sphere", "needle", "edge", "cylinder"]
ROUND: dict[str, Profile] = {"disc": UNIFORM, "flat_punch": FLAT_PUNCH, "sphere": HERTZ, "needle": ROUND_TIP}
"""Shapes whose contact is a circle, and the pressure on it."""
FLAT = ("disc", "flat_punch")
"""Those whose circle is as wide under any force."""
LAWS = ("sphere", "needle", "flat_punch")
"""Shapes with a law of force and indentation."""
STEPS, SHARE = 60, 1e-3
"""Far more than the five steps that a held cylinder takes, and the share of a force over which its slope is taken:
each step leaves about so much of the error."""


@spelled_class
@dataclass(frozen=True)
class Indenter:
    """A rigid body that presses.

    Arguments: ``radius`` [m] of a disc, flat punch, sphere, needle tip or cylinder; ``length`` [m] and ``angle``
    [rad, from x towards y] of an edge or cylinder.

    Raises:
        InputError: an unknown shape, a length or radius that it needs and that is not positive.
    """

    shape: ShapeName = "point"
    radius: float = 0.0
    length: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        if self.shape not in get_args(ShapeName):
            raise InputError(f"shape {self.shape!r}, one of {', '.join(get_args(ShapeName))} wanted")
        for name in ("radius", "length", "angle"):
            if not is_number(getattr(self, name)):
                raise InputError(f"a {self.shape} of {name} {getattr(self, name)!r}; a number wanted")
            object.__setattr__(self, name, float(getattr(self, name)))
        if self.shape in (*ROUND, "cylinder") and not self.radius > 0:
            raise InputError(f"a {self.shape} of radius {self.radius} m, a positive length wanted")
        if self.shape in ("edge", "cylinder") and not self.length > 0:
            raise InputError(f"a {self.shape} of length {self.length} m, a positive length wanted")

    def contact_radius(self, force: Floats, medium: Medium) -> Floats:
        """Radius a [m] of a round contact under normal forces [N].

        Raises:
            InputError: on a layer, forces that press the body through it.
        """
        layer = self._on_layer(medium)
        if layer is not None and self.shape != "flat_punch":
            return layer.radius(force)
        if self.shape == "sphere":
            return hertz_radius(force, self.radius, medium.contact_modulus)
        if self.shape == "needle":
            return round_tip_radius(force, self.radius, medium.contact_modulus)
        return np.full(np.shape(force), self.radius)

    def _on_layer(self, medium: Medium) -> "PressedLayer | None":
        """The law of this shape on the medium's layer, None on a half-space or for a shape without one."""
        if np.isinf(medium.thickness) or self.shape not in LAWS:
            return None
        from tactile.simulator.contacts.pressed_layer import PressedLayer  # only where called for

        return PressedLayer(self.shape, self.radius, medium)

    def force_at(self, indentation: Floats, medium: Medium) -> Floats:
        """Normal force [N] at an indentation [m].

        Raises:
            InputError: a shape for which there is no such law (a point, an edge, a uniform disc); an indentation as
                deep as the layer is thick.
        """
        if self.shape not in LAWS:
            raise InputError(f"an indentation given for a {self.shape}, a sphere, needle or flat_punch wanted")
        layer = self._on_layer(medium)
        if layer is not None:
            return layer.force(indentation)
        if self.shape == "sphere":
            return hertz_force(indentation, self.radius, medium.contact_modulus)
        if self.shape == "flat_punch":
            return punch_force(indentation, self.radius, medium.contact_modulus)
        # delta = a atanh(a / R), solved for lam = a / R by bisection, then Sneddon's force
        wanted = np.maximum(indentation, 0) / self.radius
        low, high = np.zeros_like(wanted), np.maximum(wanted + 1, np.sqrt(wanted))
        for _ in range(60):
            middle = (low + high) / 2
            less = np.tanh(middle) * middle < wanted
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        lam, bend = np.tanh((low + high) / 2), (low + high) / 2
        small = lam < 1e-3
        scaled = np.where(small, 4 / 3 * wanted**1.5, (lam**2 + 1) * bend - lam)
        force: Floats = medium.contact_modulus * self.radius**2 * scaled
        return force

    def force_on(self, radius: Floats, medium: Medium) -> Floats:
        """Normal force [N] with which the contact is so wide [m]; of a flat punch, at 1 m of indentation.

        Raises:
            InputError: on a layer, a contact beyond the tables.
        """
        layer = self._on_layer(medium)
        if layer is not None:
            return layer.force_on(radius)
        stiff = medium.contact_modulus
        if self.shape == "flat_punch":
            return 2 * stiff * radius
        if self.shape == "needle":
            lam = np.minimum(radius / self.radius, 1 - 1e-15)
            return stiff * self.radius**2 * ((lam**2 + 1) * np.arctanh(lam) - lam)
        return 4 / 3 * stiff * radius**3 / self.radius

    def profile(self, medium: Medium) -> tuple[Profile, float]:
        """Pressure of a round contact, and the length [m] by which its radius becomes the profile's lam."""
        layer = self._on_layer(medium)
        if layer is not None:
            return layer.profile, medium.thickness
        return ROUND[self.shape], self.radius if self.shape == "needle" else np.inf

    def sticking(self, force: Floats, stuck: Floats, medium: Medium) -> tuple[Floats, Floats, Profile] | None:
        """Radii [m] of circles that stick, what of a pull is taken off there like a pressure, and the rest's shape.

        None where all of it is a pressure.

        As on a half-space and under a flat end, where it is the pressure under the force ``stuck`` [N], a part of the
        contact's ``force`` [N].

        Source: ``tactile.elastic.layer_slip``.
        """
        layer = self._on_layer(medium)
        if layer is None or self.shape == "flat_punch":
            return None
        return layer.sticking(layer.radius(force), stuck / np.where(force > 0, force, 1.0))

    def carrying(self, medium: Medium) -> "Carry | None":
        """What becomes of the rings of friction when the normal force changes, None where they stay as they are.

        Source: ``PressedLayer.carried_over``.
        """
        layer = self._on_layer(medium)
        return None if layer is None or self.shape == "flat_punch" else layer.carried_over

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Indentation [m] of a body under normal forces [N], 0 where nothing presses.

        An edge is a cylinder of its ``radius``; a uniform disc sinks in like a flat punch.

        Raises:
            InputError: as ``contact_radius``; a point, which has no size.

        Source: Johnson, Contact Mechanics, eqs (4.23), (3.36); Sneddon (1965); ``lines`` for the
        cylinder.
        """
        if self.shape == "disc":
            return replace(self, shape="flat_punch").indentation(force, medium)
        pressing, stiff = np.maximum(force, 0), medium.contact_modulus
        layer = self._on_layer(medium)
        if layer is not None:
            return layer.indentation(pressing)
        if self.shape == "sphere":
            return hertz_indentation(pressing, self.radius, stiff)
        if self.shape == "flat_punch":
            return pressing / (2 * self.radius * stiff)
        if self.shape == "needle":
            return round_tip_indentation(pressing, self.radius, stiff)
        if self.shape in ("edge", "cylinder"):
            from tactile.elastic.lines import cylinder_half_width, line_indentation  # only where called for

            width = cylinder_half_width(pressing, self.length, self.radius, medium)
            deep = line_indentation(pressing, self.length, width, medium)
            if (deep >= medium.thickness).any():
                raise InputError(
                    f"a {self.shape} {self.length * 1e3:g} mm long sinks {deep.max() * 1e3:.4g} mm under "
                    f"{pressing.max():.4g} N into a cover of {medium.thickness * 1e3:g} mm; less than its "
                    "thickness wanted"
                )
            return deep
        raise InputError(f"the indentation of a {self.shape}, which has no size; another shape wanted")

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, needle: float) -> Floats:
        """By what the force of a body that is held at its height grows when the cover rises by ``rise`` [m].

        From the shape's own law of force and indentation; a point is a tip of radius ``needle`` [m], an edge as round
        as that. What does not press (force 0 or pulling) stays as it is.
        """
        if self.shape == "point":
            if np.isfinite(medium.thickness):
                from tactile.simulator.contacts import tip  # only where called for

                return tip.held_factor(force, rise, needle, medium)
            return Indenter("sphere", needle).held_factor(force, rise, medium, needle)
        if self.shape == "edge":
            return replace(self, shape="cylinder", radius=needle).held_factor(force, rise, medium, needle)
        deeper = self.indentation(force, medium) + rise
        pressing = force > 0
        if self.shape == "cylinder":
            new = self._pressed_to(deeper, force, medium)
        else:
            law = replace(self, shape="flat_punch") if self.shape == "disc" else self
            new = law.force_at(deeper, medium)
        factor: Floats = np.where(pressing, new / np.where(pressing, force, 1.0), 1.0)
        return factor

    def _pressed_to(self, deeper: Floats, force: Floats, medium: Medium) -> Floats:
        """Force [N] of a cylinder at indentations [m], 0 where there is no contact, begun at forces that press.

        There is no closed form; the indentation is nearly a power of the force, so Newton, in logarithms.

        Raises:
            InputError: as ``indentation``; deeper than one so short sinks in under any force.
        """
        touches = (deeper > 0) & (force > 0)
        now, aim = force[touches], deeper[touches]
        for _ in range(STEPS):
            near, aside = self.indentation(now, medium), self.indentation(now * (1 - SHARE), medium)
            with np.errstate(invalid="ignore"):
                power = np.log(near / aside) / -np.log1p(-SHARE)
            if not ((near > 0) & (power > 0) | (aim == near)).all():
                raise InputError(
                    f"a {self.shape} {self.length * 1e3:g} mm long held {aim.max() * 1e3:.4g} mm deep; less "
                    "wanted: its contact would be far wider than it is long"
                )
            before, now = now, now * (aim / near) ** (1 / power)
            if (np.abs(now - before) <= 1e-11 * now).all():  # a thousandth of it is left, see SHARE
                break
        new = np.zeros_like(force)
        new[touches] = now
        return new
