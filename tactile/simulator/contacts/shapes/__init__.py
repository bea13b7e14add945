"""Shapes of indenters, one module each: contact radius, pressure, force law and adhesion. ``SHAPES`` lists all."""

from tactile.simulator.contacts.shapes.cylinder import Cylinder
from tactile.simulator.contacts.shapes.disc import DiscShape
from tactile.simulator.contacts.shapes.edge import EdgeShape
from tactile.simulator.contacts.shapes.flat_punch import FlatPunch
from tactile.simulator.contacts.shapes.needle import Needle
from tactile.simulator.contacts.shapes.point import PointShape
from tactile.simulator.contacts.shapes.shape import IndenterShape, LineShape, RoundShape
from tactile.simulator.contacts.shapes.sphere import Sphere

SHAPES: dict[str, type[IndenterShape]] = {
    shape.name: shape for shape in (PointShape, DiscShape, FlatPunch, Sphere, Needle, EdgeShape, Cylinder)
}
"""All shapes by the name that a scene gives them."""
ROUND = tuple(name for name, shape in SHAPES.items() if issubclass(shape, RoundShape))
"""Shapes whose contact is a circle."""
LAWS = tuple(name for name, shape in SHAPES.items() if shape.has_law)
"""Shapes with a law of force and indentation."""

__all__ = ["LAWS", "ROUND", "SHAPES", "IndenterShape", "LineShape", "RoundShape"]
