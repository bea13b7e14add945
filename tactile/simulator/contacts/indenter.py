"""Indenters: a shape with its sizes, as a scene and Python name it."""

from dataclasses import dataclass
from functools import cached_property

from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.shapes import LAWS as LAWS
from tactile.simulator.contacts.shapes import SHAPES, IndenterShape, RoundShape


@spelled_class
@dataclass(frozen=True)
class Indenter:
    """A rigid body that presses.

    Arguments: ``shape``: "point", "disc", "flat_punch", "sphere", "needle", "edge" or "cylinder"; ``radius`` [m] of a
    disc, flat punch, sphere, needle tip or cylinder; ``length`` [m] and ``angle`` [rad, from x towards y] of an edge or
    cylinder.

    Raises:
        InputError: an unknown shape, a length or radius that it needs and that is not positive.
    """

    shape: str = "point"
    radius: float = 0.0
    length: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise InputError(f"shape {self.shape!r}, one of {', '.join(SHAPES)} wanted")
        for name in ("radius", "length", "angle"):
            if not is_number(getattr(self, name)):
                raise InputError(f"a {self.shape} of {name} {getattr(self, name)!r}; a number wanted")
            object.__setattr__(self, name, float(getattr(self, name)))
        for name in SHAPES[self.shape].needs:
            if not getattr(self, name) > 0:
                raise InputError(f"a {self.shape} of {name} {getattr(self, name)} m, a positive length wanted")

    @cached_property
    def body(self) -> IndenterShape:
        """The shape with these sizes."""
        return SHAPES[self.shape](self.radius, self.length, self.angle)

    @property
    def round(self) -> RoundShape:
        """The shape, whose contact is a circle.

        Raises:
            InputError: another shape.
        """
        if not isinstance(self.body, RoundShape):
            raise InputError(f"a {self.shape}, one of {', '.join(LAWS)} wanted")
        return self.body

    def contact_radius(self, force: Floats, medium: Medium) -> Floats:
        """Return the radius [m] of a round contact under normal forces [N]: see ``RoundShape.contact_radius``."""
        return self.round.contact_radius(force, medium)

    def force_at(self, indentation: Floats, medium: Medium) -> Floats:
        """Return the normal force [N] at an indentation [m]: see ``IndenterShape.force_at``."""
        return self.body.force_at(indentation, medium)

    def indentation(self, force: Floats, medium: Medium) -> Floats:
        """Return the indentation [m] under normal forces [N]: see ``IndenterShape.indentation``."""
        return self.body.indentation(force, medium)

    def held_factor(self, force: Floats, rise: Floats, medium: Medium, tip_radius: float) -> Floats:
        """Return the growth of a held body's force when the cover rises: see ``IndenterShape.held_factor``."""
        return self.body.held_factor(force, rise, medium, tip_radius)
