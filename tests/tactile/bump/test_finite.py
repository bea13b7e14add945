"""Finite strain: derivatives against differences, the small-strain limit, closed forms, rotations, prestress."""

from collections.abc import Callable

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.bump.body import Body
from tactile.bump.finite import balance, push_to
from tactile.bump.kinematics import HALF, PLANE, PRESSED, Kinematics
from tactile.bump.law import Displacement, Law, Mixed, PlaneStress, stress, tangent
from tactile.bump.mesh import half_section, whole_section
from tactile.bump.plate import Push, plate_constraint, respond, stiffness
from tactile.bump.shape import Shape
from tactile.bump.touch import lower
from tactile.elastic.medium import Medium
from tests.tactile.bump.test_elements import on_boundary, shaken

LAWS = (Mixed, Displacement, PlaneStress)


def energy(law: Law, gradient: Floats, pressure: float) -> float:
    """The energies of the laws' docstrings, written out."""
    g, nu = law.medium.shear_modulus, law.medium.nu
    lam = 2 * g * nu / (1 - 2 * nu)
    if isinstance(law, PlaneStress):  # the least over the thickness, by search
        thick = np.linspace(0.3, 3, 2_000_001)
        volume = np.linalg.det(gradient) * thick
        invariant = (gradient[::2, ::2] ** 2).sum() + thick**2
        return float((g / 2 * (invariant - 3 - 2 * np.log(volume)) + lam / 2 * (volume - 1) ** 2).min())
    volume = np.linalg.det(gradient)
    squeezed = pressure * (volume - 1) if isinstance(law, Mixed) else lam / 2 * (volume - 1) ** 2
    return float(g / 2 * ((gradient**2).sum() - 3 - 2 * np.log(volume)) + squeezed)


@pytest.mark.parametrize("kind", LAWS)
def test_stress_and_tangent_are_derivatives_of_the_energy(kind: Callable[[Medium], Law]) -> None:
    law, random = kind(Medium(2.0, 0.4)), np.random.default_rng(5)
    for _ in range(3):
        gradient = np.eye(3) + 0.2 * random.normal(size=(3, 3))
        if kind is PlaneStress:
            gradient[1], gradient[:, 1] = 0, 0
            gradient[1, 1] = 1
        pressure = np.array(0.7)
        first, inverse, _, s, m = stress(law, gradient, pressure)
        slope = tangent(law, inverse, s, m)
        change = random.normal(size=(3, 3))
        if kind is PlaneStress:
            change[1], change[:, 1] = 0, 0
        step = 1e-4
        work = energy(law, gradient + step * change, 0.7) - energy(law, gradient - step * change, 0.7)
        assert (first * change).sum() == pytest.approx(work / 2 / step, rel=1e-6)
        ahead, behind = (stress(law, gradient + sign * 1e-6 * change, pressure)[0] for sign in (1, -1))
        wanted = ((ahead - behind) / 2e-6)[::2, ::2] if kind is PlaneStress else (ahead - behind) / 2e-6
        got = (slope @ change.reshape(9)).reshape(3, 3)
        assert (got[::2, ::2] if kind is PlaneStress else got) == pytest.approx(wanted, abs=1e-7)


@pytest.mark.parametrize(
    ("kinematics", "kind"), [(PLANE, PlaneStress), (PLANE, Mixed), (PRESSED, Mixed), (PRESSED, Displacement)]
)
def test_the_bodys_stiffness_is_the_derivative_of_its_forces(
    kinematics: Kinematics, kind: Callable[[Medium], Law]
) -> None:
    body, random = Body(shaken(3), kinematics, kind(Medium(1.0, 0.45))), np.random.default_rng(6)
    state = 0.02 * random.normal(size=body.size)
    state[body.component == 0] *= body.place[0, body.component == 0]  # nothing leaves the axis
    change = random.normal(size=body.size)
    gradient, pressure = body.at_points(state)
    assert (np.linalg.det(gradient) > 0).all()
    step = 1e-6
    wanted = (body.forces(state + step * change) - body.forces(state - step * change)) / (2 * step)
    matrix = body.stiffness(gradient, pressure)
    assert np.abs(matrix @ change - wanted).max() < 1e-7 * np.abs(wanted).max()
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()


@pytest.mark.parametrize("push", ("press", "shift"))
def test_small_strain_is_the_limit(push: Push) -> None:
    shape = Shape()
    body = Body(whole_section(shape, 0.5), PLANE, PlaneStress(Medium(1.0, 0.499)))
    constraint = plate_constraint(body, shape, push)
    linear = respond(body, constraint)
    gaps = []
    for moved in (1e-5, 1e-6, 1e-7):
        state = push_to(body, constraint, moved)
        gaps.append(np.abs(state / moved - linear).max() / np.abs(linear).max())
        assert constraint.force(body.forces(state)) / moved == pytest.approx(
            stiffness(body, constraint, linear), rel=100 * moved / 1e-5 * 1e-2
        )
    assert gaps[0] > 5 * gaps[1] > 25 * gaps[2]  # the first term left out is quadratic
    assert gaps[2] < 1e-3


def test_uniaxial_rubber_is_treloars() -> None:
    # incompressible neo-Hookean: force over first area = G (l - 1 / l^2)
    medium = Medium(3.0, 0.5)
    body = Body(shaken(2), PRESSED, Mixed(medium))
    for stretch in (0.6, 1.5):
        r, z = body.place
        exact = np.where(body.component == 0, r * (stretch**-0.5 - 1), (z - 1) * (stretch - 1))
        ends = (body.component == 1) & ((z < 1 + 1e-9) | (z > 2 - 1e-9))
        fixed = np.flatnonzero(ends | ((body.component == 0) & (r < 1e-9)))
        start = np.where(body.component >= 0, exact, 0)
        state = balance(body, 0.9 * start, fixed, exact[fixed])
        assert state is not None
        moves = body.component >= 0
        assert np.abs(state - exact)[moves].max() < 1e-9
        top = (body.component == 1) & (z > 2 - 1e-9)
        assert body.forces(state)[top].sum() / np.pi == pytest.approx(stretch - stretch**-2, rel=1e-8)


def test_plane_stress_rubber_in_equal_biaxial_load() -> None:
    # incompressible: P = G (l - l^-5)
    medium = Medium(3.0, 0.5)
    body = Body(shaken(2), PLANE, PlaneStress(medium))
    stretch = 1.3
    x, z = body.place
    state = np.where(body.component == 0, x, z - 1) * (stretch - 1)
    forces = body.forces(state)
    right = (body.component == 0) & (x > 1 - 1e-9)
    assert forces[right].sum() == pytest.approx(stretch - stretch**-5, rel=1e-12)
    inner = ~on_boundary(body)
    assert np.abs(forces[inner]).max() < 1e-12


def test_what_cannot_be_balanced_is_said() -> None:
    shape = Shape(contact=0.05e-3)
    body = Body(whole_section(shape, 0.5), PLANE, PlaneStress(Medium(1.0, 0.499)))
    with pytest.raises(InputError, match="a plate moved by 390 um: no balance of forces beyond"):
        push_to(body, plate_constraint(body, shape, "press"), 3.9e-4)
    half = Body(half_section(Shape(contact=0.02e-3), 0.4, True), HALF, PlaneStress(Medium(1.0, 0.4)))
    with pytest.raises(InputError, match="smaller steps"):
        list(lower(half, Shape(contact=0.02e-3), [6e-4], True))
    assert not push_to(body, plate_constraint(body, shape, "press"), 0.0).any()
