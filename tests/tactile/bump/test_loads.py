"""The loaded body: against the layer's theory and Hertz; balance, reciprocity."""

import itertools
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from skfem import FacetBasis, LinearForm, MeshTri

from cnnsim.support import Floats, InputError
from tactile.bump.body import Body, solve
from tactile.bump.kinematics import HALF, PLANE, PRESSED, SHEARED, Kinematics
from tactile.bump.law import Mixed, PlaneStress
from tactile.bump.mesh import half_section, whole_section
from tactile.bump.plate import Push, plate_constraint, respond
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.bump.touch import lower
from tactile.bump.triangulate import straight, triangulate
from tactile.elastic.gauss import gauss
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.profiles import hertz_radius
from tests.oracles.elastic.layer import layer_load

ALONG: tuple[tuple[Push, int], ...] = ("press", 0), ("shift", 1)
"""What the plate does, and the component across it."""


@cache
def flat_mesh() -> MeshTri:
    """A layer of thickness 1 and radius 6 without a bump, fine around a disc of radius 0.3."""
    corners = [(0.0, 0.0), (0.3, 0.0), (6.0, 0.0), (6.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
    points, triangles = triangulate(
        [straight(a, b) for a, b in itertools.pairwise(corners)],
        lambda p: np.asarray((p > 0).all(axis=1) & (p < (6, 1)).all(axis=1)),
        lambda p: np.minimum(0.02 + 0.12 * np.hypot(p[:, 0] - 0.3, p[:, 1]), 0.25),
    )
    return MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))


@pytest.mark.parametrize("nu", (0.3, 0.5))
@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.parametrize(("kinematics", "force"), [(PRESSED, (0.0, 0.0, 1.0)), (SHEARED, (1.0, 0.0, 0.0))])
def test_a_disc_on_a_flat_layer(
    kinematics: Kinematics, force: tuple[float, float, float], quantity: FieldQuantity, nu: float
) -> None:
    """Elements against Fourier's solution of the bonded layer, normal and shear traction."""
    medium = Medium(2.0, nu, quantity)
    body = Body(flat_mesh(), kinematics, Mixed(medium))
    pull = np.pi * 0.3**2
    component = 1  # w under a press; under a shear q (U cos^2 - V sin^2): the pull works on U - V
    facets = body.mesh.facets_satisfying(lambda x: (x[1] < 1e-9) & (x[0] < 0.3))
    edge = FacetBasis(body.mesh, body.basis.elem, facets=facets, intorder=4)
    traction = LinearForm(lambda v, w: v[component] * w.x[0] * kinematics.around / pull).assemble(edge)
    load = np.concatenate([traction, np.zeros(body.size - body.basis.N)])
    r, z = body.place
    fixed = (body.component >= 0) & (z > 1 - 1e-9)
    for k in kinematics.axis:
        fixed |= (body.component == k) & (r < 1e-9)
    state = solve(body.stiffness(*body.rest()), load, np.flatnonzero(fixed), np.zeros(fixed.sum()))
    at = np.array([(0.2, 0.4), (0.5, 0.4), (0.1, 0.8), (1.0, 0.8)])
    got = Probe(body, at).strain(state) if quantity == "strain" else Probe(body, at).stress(state)
    nodes, weights = gauss(10)
    rho, step = 0.15 * (nodes + 1), 0.15 * weights
    turn = np.arange(24) * 2 * np.pi / 24
    loads = np.zeros((10, 24, 5))
    loads[..., 0], loads[..., 1] = rho[:, None] * np.cos(turn), rho[:, None] * np.sin(turn)
    loads[..., 2:] = (rho * step)[:, None, None] / pull * 2 * np.pi / 24 * np.array(force)
    for point, felt in zip(at, got, strict=True):
        wanted = layer_load((point[0], 0.0), point[1], loads.reshape(-1, 5), 1.0, medium)
        size = np.abs(wanted).max()
        assert felt[0, 2] == pytest.approx(wanted[0], abs=0.01 * size)
        assert felt[2, 2] == pytest.approx(wanted[2], abs=0.01 * size)
    if kinematics is SHEARED:  # and around the corner, theta = 90 degrees
        wanted = layer_load((0.0, 0.5), 0.4, loads.reshape(-1, 5), 1.0, medium)
        assert -got[1, 1, 2] == pytest.approx(wanted[0], rel=0.02)


def test_a_plate_on_a_sphere_is_hertz() -> None:
    """Contact radius against force, a^3 = 3 F R / (4 E*): local, so that what carries the bump plays no part."""
    shape = Shape(1.0, 10.0, 10.0, 0.08, 0.1)
    body = Body(half_section(shape, 2.0), PRESSED, Mixed(Medium(1.0, 0.5)))
    touch = list(lower(body, shape, np.linspace(2e-3, 8e-3, 4), False))[-1]
    wanted = float(hertz_radius(touch.force, 1.0, 1 / 0.75))
    # whole nodes touch: the true edge lies within the spacing there, 3 % of the radius
    assert touch.contact == pytest.approx(wanted, rel=0.05)


def plane(nu: float = 0.499, fineness: float = 0.6) -> tuple[Body, Shape]:
    shape = Shape()
    return Body(whole_section(shape, fineness), PLANE, PlaneStress(Medium(1.0, nu))), shape


def test_forces_and_moments_balance() -> None:
    body, shape = plane()
    for push, across in ALONG:
        component = 1 - across
        constraint = plate_constraint(body, shape, push)
        state = respond(body, constraint)
        forces = body.stiffness(*body.rest()) @ state
        assert constraint.force(forces) > 0
        assert constraint.force(forces) == pytest.approx(state @ forces, rel=1e-10)  # the work of a unit displacement
        free = np.setdiff1d(np.arange(body.size), constraint.fixed)
        assert np.abs(forces[free]).max() < 1e-10 * np.abs(forces).max()
        for k in (0, 1):
            assert abs(forces[body.component == k].sum()) < 1e-10 * np.abs(forces).sum()
        bottom = (body.component == component) & (body.place[1] > shape.thickness - 1e-9)
        assert forces[bottom].sum() == pytest.approx(-constraint.force(forces), rel=1e-9)
        x, z = body.place
        turn = np.where(body.component == 0, z, -x) @ forces
        assert abs(turn) < 1e-10 * shape.thickness * np.abs(forces).sum()


def test_a_growing_contact_grows_and_knows_no_scale() -> None:
    def curve(scale: float, modulus: float) -> Floats:
        shape = Shape(*(scale * length for length in (0.2, 1.0, 1.0, 0.02, 0.02)))
        body = Body(half_section(shape, 0.5, True), HALF, PlaneStress(Medium(modulus, 0.4)))
        steps = scale * np.linspace(0.01, 0.08, 8)
        return np.array([(t.contact / scale, t.force / scale / modulus) for t in lower(body, shape, steps, False)])

    one = curve(1.0, 1.0)
    assert one == pytest.approx(curve(1e-3, 2e6), rel=1e-7)
    assert (np.diff(one[:, 0]) >= 0).all()  # it grows by whole nodes
    assert one[-1, 0] > 1.5 * one[0, 0]
    assert (np.diff(one[:, 1]) > 0).all()
    with pytest.raises(InputError, match="growing ones wanted"):
        list(lower(*_half(), [2e-5, 1e-5], False))


def _half() -> tuple[Body, Shape]:
    shape = Shape(contact=0.02e-3)
    return Body(half_section(shape, 0.4, True), HALF, PlaneStress(Medium(1.0, 0.4))), shape


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Shape(radius=-1.0), "radius -1.0 m"),
        (lambda: Shape(contact=0.2e-3), "a contact below 0.95"),
        (lambda: Shape(fillet=0.15e-3), "a fillet up to 0.5"),
        (lambda: Shape(reach=0.21e-3), "a body 0.00021 m to each side"),
        (lambda: Shape(thickness=np.nan), "thickness nan"),
    ],
)
def test_wrong_shapes_are_refused(make: Callable[[], Shape], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("finite", [False, True])
def test_a_contact_that_grows_lets_go_where_it_would_pull(finite: bool) -> None:
    """So it is the same in two steps as in ten, and no node of it hangs on the plate."""
    body, shape = _half()
    ends = []
    for steps in (2, 10):
        *_, last = lower(body, shape, np.linspace(0, 5e-5, steps + 1)[1:], finite)
        forces = body.forces(last.state) if finite else body.stiffness(*body.rest()) @ last.state
        arc = shape.curved(np.abs(body.place.T) * (1, -1)) & (body.component == 1)
        assert forces[arc].min() > -1e-9 * forces[arc].max()
        ends.append((last.contact, last.force))
    assert ends[0][0] == ends[1][0]
    assert ends[0][1] == pytest.approx(ends[1][1], rel=5e-3)
