"""Meshes of the bump: no flat element at any fineness, and a strain next to nothing that is the same on all of them."""

import numpy as np
import pytest
from skfem import MeshTri

from examples.paper.bump import SENSOR
from tactile.bump.mesh import plane_mesh
from tactile.bump.shape import Shape

pytestmark = pytest.mark.slow


def flattest(mesh: MeshTri) -> float:
    """Twice the smallest area over the square of its triangle's longest side; 0.87 where it is equilateral."""
    a, b, c = mesh.p[:, mesh.t].transpose(1, 2, 0)
    one, two = b - a, c - a
    area = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    longest = np.max([(side**2).sum(axis=1) for side in (one, two, c - b)], axis=0)
    return float((area / longest).min())


@pytest.mark.parametrize("contact", (30e-6, 100e-6, 140e-6))
@pytest.mark.parametrize("fineness", (0.7, 1.45, 2.4, 3.0))
def test_no_element_is_flat(contact: float, fineness: float) -> None:
    """Inner points less than 1e-4 radii from the arc were put on it, and spoiled meshes of fineness 2.4 and 3."""
    shape = Shape(contact=contact)
    mesh = plane_mesh(shape, fineness, sensor=SENSOR)
    assert flattest(mesh) > 0.2
    on_arc, outer = shape.curved(mesh.p.T), np.unique(mesh.facets[:, mesh.boundary_facets()])
    assert set(np.flatnonzero(on_arc)) <= set(outer)
    assert (on_arc & np.isclose(mesh.p[0], contact, rtol=1e-12, atol=0)).sum() == 1  # the contact ends at a vertex
