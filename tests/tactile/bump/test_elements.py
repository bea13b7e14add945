"""The elements themselves: patches, declared orders against closed forms, no locking, and the mesh they stand on."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from skfem import MeshTri

from cnnsim.support import Floats
from tactile.bump.body import Body, solve
from tactile.bump.kinematics import PLANE, PRESSED, SHEARED, Kinematics
from tactile.bump.law import Displacement, Law, Mixed, PlaneStress
from tactile.bump.mesh import half_section, plane_mesh
from tactile.bump.plate import plate_constraint, respond, stiffness
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.elastic.medium import Medium
from tests.oracles.elastic.point_loads import boussinesq, cerruti


def shaken(count: int, low: float = 1.0) -> MeshTri:
    """The square 0 .. 1 x low .. low + 1 in uneven triangles."""
    side = np.linspace(0, 1, count + 1)
    mesh = MeshTri.init_tensor(side, side)
    inner = ((mesh.p > 1e-9) & (mesh.p < 1 - 1e-9)).all(axis=0)
    points = mesh.p + np.where(inner, np.random.default_rng(1).uniform(-0.2, 0.2, mesh.p.shape) / count, 0)
    return MeshTri(points + np.array([[0], [low]]), mesh.t)


def on_boundary(body: Body) -> NDArray[np.bool_]:
    x, z = body.place
    return (body.component >= 0) & ((x > 1 - 1e-9) | (x < 1e-9) | (z < z.min() + 1e-9) | (z > z.max() - 1e-9))


def with_boundary(body: Body, exact: Callable[[Floats, Floats], Floats], fixed: NDArray[np.bool_]) -> Floats:
    index = np.flatnonzero(fixed)
    values = exact(*body.place)[body.component[index], index]
    return solve(body.stiffness(*body.rest()), np.zeros(body.size), index, values)


@pytest.mark.parametrize(
    ("degree", "kinematics", "law", "exact"),
    [
        (1, PLANE, PlaneStress, lambda x, z: np.stack([0.3 * x - 0.2 * z, 0.1 * x + 0.5 * z])),
        (2, PLANE, PlaneStress, lambda x, z: np.stack([0.3 * x - 0.2 * z, 0.1 * x + 0.5 * z])),
        # pure bending, exact for quadratic displacements: u = x z, w = -(x^2 + nu z^2) / 2
        (2, PLANE, PlaneStress, lambda x, z: np.stack([x * z, -(x**2 + 0.4 * z**2) / 2])),
        (2, PLANE, Mixed, lambda x, z: np.stack([0.3 * x - 0.2 * z, 0.1 * x + 0.5 * z])),
        (2, PRESSED, Mixed, lambda r, z: np.stack([0.3 * r, 0.5 * z])),
        # a rigid shift along x, a tilt about y and a shear: U = z, V = -z, W = r
        (2, SHEARED, Mixed, lambda r, z: np.stack([0 * r, 2 + 2 * z, 0.3 * r])),
    ],
)
def test_patches_are_exact(
    degree: int, kinematics: Kinematics, law: Callable[[Medium], Law], exact: Callable[[Floats, Floats], Floats]
) -> None:
    body = Body(shaken(4), kinematics, law(Medium(2.0, 0.4)), degree)
    wanted = exact(*body.place)[np.maximum(body.component, 0), np.arange(body.size)]
    got = with_boundary(body, exact, on_boundary(body))
    moves = body.component >= 0
    assert np.abs(got - wanted)[moves].max() < 1e-12
    middle = np.array([[0.37, 1.41], [0.8, 1.9]])
    assert Probe(body, middle).displacement(got) == pytest.approx(exact(*middle.T).T, abs=1e-12)


@pytest.mark.parametrize("nu", (0.0, 0.3, 0.4999, 0.5))
@pytest.mark.parametrize(("kinematics", "exact"), [(PRESSED, boussinesq), (SHEARED, cerruti)])
def test_orders_are_as_declared(kinematics: Kinematics, exact: Callable[..., Floats], nu: float) -> None:
    """Order 3 in the displacement, 2 in strain, against Boussinesq and Cerruti below the load."""
    errors = []
    for count in (4, 8, 16):
        body = Body(shaken(count), kinematics, Mixed(Medium(2 * (1 + nu), nu)))
        state = with_boundary(body, lambda r, z: exact(r, z, nu), on_boundary(body))
        at = np.asarray(body.basis.global_coordinates())
        moved = np.asarray(body.basis.interpolate(state[: body.basis.N]))
        off = ((moved - exact(*at, nu)) ** 2).sum(axis=0)
        step = 1e-5
        slopes = [
            (exact(at[0] + a, at[1] + b, nu) - exact(at[0] - a, at[1] - b, nu)) / (2 * step)
            for a, b in ((step, 0), (0, step))
        ]
        wanted = kinematics.gradient(exact(*at, nu), np.stack(slopes, axis=1), at[0])
        gap = ((body.at_points(state)[0] - np.eye(3) - wanted.transpose(2, 3, 0, 1)) ** 2).sum((-1, -2))
        errors.append([np.sqrt((part * body.weight).sum()) for part in (off, gap)])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])[-1]
    assert orders[0] > 2.8
    assert orders[1] > 1.8
    assert errors[-1][0] < 2e-5


def test_taylor_hood_does_not_lock_and_linear_elements_do() -> None:
    """Error of the bump's stiffness at nu = 0.4999 against 0.3 on the same coarse mesh."""

    def stiff(nu: float, fineness: float, degree: int, law: Callable[[Medium], Law]) -> float:
        shape = Shape()
        mesh = plane_mesh(shape, fineness) if degree == 1 else half_section(shape, fineness)
        body = Body(mesh, PRESSED, law(Medium(1.0, nu)), degree)
        constraint = plate_constraint(body, shape, "press")
        return stiffness(body, constraint, respond(body, constraint))

    errors = {}
    for nu in (0.3, 0.4999):
        fine = stiff(nu, 2.0, 2, Mixed)
        for name, degree, law in (("mixed", 2, Mixed), ("linear", 1, Displacement), ("quadratic", 2, Displacement)):
            errors[name, nu] = stiff(nu, 0.7, degree, law) / fine - 1
    assert errors["mixed", 0.3] < 0.005
    assert errors["mixed", 0.4999] < 2 * errors["mixed", 0.3]
    assert errors["linear", 0.4999] > 10 * errors["linear", 0.3]
    assert errors["linear", 0.4999] > 3  # five times as stiff as it should be
    assert errors["quadratic", 0.4999] > 3 * errors["mixed", 0.4999]


def test_meshes_keep_to_their_size_and_shape() -> None:
    shape = Shape()
    counts = []
    for fineness in (0.5, 1.0, 2.0):
        mesh = plane_mesh(shape, fineness)
        p = mesh.p[:, mesh.t]
        sides = [np.linalg.norm(p[:, a] - p[:, b], axis=0) for a, b in ((0, 1), (1, 2), (2, 0))]
        area = mesh_areas(p)
        quality = 4 * np.sqrt(3) * area / sum(side**2 for side in sides)
        assert quality.min() > 0.55  # 1 for the equilateral triangle
        counts.append(mesh.t.shape[1])
        body = Body(half_section(shape, fineness), PRESSED, Mixed(Medium(1.0, 0.3)))
        fillet = np.pi * shape.fillet**2 * (shape.foot - shape.fillet / 3)  # roughly: the corner's ring
        assert body.weight.sum() == pytest.approx(
            np.pi * shape.reach**2 * shape.thickness + 2 / 3 * np.pi * shape.radius**3 + fillet, rel=1e-4
        )
    assert counts[2] > 3 * counts[1] > 8 * counts[0]


def mesh_areas(p: Floats) -> Floats:
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return np.asarray(np.abs(a[0] * b[1] - a[1] * b[0]) / 2)
