"""Loads over circles: against closed forms, other people's Hertz, and many point loads."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.discs import disc_load
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.profiles import (
    FLAT_PUNCH,
    HERTZ,
    ROUND_TIP,
    UNIFORM,
    Profile,
    hertz_force,
    hertz_indentation,
    hertz_radius,
    round_tip_radius,
)
from tactile.elastic.unit_disc import layer

random = np.random.default_rng(3)
LAM = 0.9
Pressure = Callable[[NDArray[np.float64]], NDArray[np.float64]]
PRESSURES: dict[str, tuple[Profile, Pressure]] = {
    "flat punch": (FLAT_PUNCH, lambda r: 1 / (2 * np.pi * np.sqrt(1 - r * r))),
    "uniform": (UNIFORM, lambda r: np.full_like(r, 1 / np.pi)),
    "hertz": (HERTZ, lambda r: 1.5 / np.pi * np.sqrt(1 - r * r)),
}
"""Unit load on a unit circle."""


def on_a_disc(
    pressure: Pressure, count: int = 120, around: int = 64
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places (n, 2) and shares (n,) of point loads that make up the pressure: r = sin(t) tames the rim."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    t, step = (nodes + 1) * np.pi / 4, weights * np.pi / 4
    r = np.sin(t)
    azimuth = (np.arange(around) + 0.5) * 2 * np.pi / around
    places = r[:, None, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    share = pressure(r) * r * np.cos(t) * step * 2 * np.pi / around
    return places.reshape(-1, 2), np.repeat(share, around)


@pytest.mark.parametrize("name", PRESSURES)
@pytest.mark.parametrize(("nu", "quantity"), [(0.5, "strain"), (0.3, "stress")])
def test_a_disc_is_many_points(name: str, nu: float, quantity: FieldQuantity) -> None:
    profile, pressure = PRESSURES[name]
    places, share = on_a_disc(pressure)
    assert share.sum() == pytest.approx(1, rel=1e-12)
    force, medium = np.array((0.3, -0.2, 0.5)), Medium(2.0, nu, quantity)
    at = random.uniform(-2, 2, (25, 2))
    for depth, radius in ((0.5, 1.0), (0.9, 0.7), (3.0, 0.02)):
        points = np.concatenate([places * radius + (0.1, 0.2), share[:, None] * force], axis=1)
        wanted = point_load(at, depth, points, medium)
        got = disc_load(at, depth, [[0.1, 0.2, *force]], [radius], profile, medium)
        assert np.abs(got - wanted).max() < 1e-11 * np.abs(wanted).max()


def test_closed_forms_of_the_punch_and_of_hertz_at_any_depth() -> None:
    # T_zz = (dV/dz - z d2V/dz2) / 2 pi with the potentials of Johnson's sect. 3.8, written with complex z + i a
    rho = np.array([0.0, 0.3, 0.99, 1.0, 1.01, 1.7, 4.0])
    at, medium = np.stack([rho, 0 * rho], axis=-1), Medium(1.0, quantity="stress")
    for depth, bound in ((0.02, 1e-10), (0.3, 1e-13), (2.0, 1e-13)):
        s = depth + 1j
        root = np.sqrt(rho**2 + s**2)
        punch = (1 / root).imag + depth * (s / root**3).imag
        hertz = -3 * ((root - depth * np.log(s + root)).imag - depth * (1j / root - np.log(s + root)).imag)
        for profile, wanted in ((FLAT_PUNCH, punch / (2 * np.pi)), (HERTZ, hertz / (2 * np.pi))):
            got = disc_load(at, depth, [[0, 0, 0, 0, 1.0]], [1.0], profile, medium)[:, 2]
            assert np.abs(got - wanted).max() < bound * np.abs(wanted).max()


@pytest.mark.parametrize("profile", (FLAT_PUNCH, UNIFORM, HERTZ, ROUND_TIP), ids=lambda profile: profile.name)
def test_a_plane_carries_the_load_and_far_away_it_is_a_point(profile: Profile) -> None:
    nodes, weights = np.polynomial.legendre.leggauss(120)
    slant = (nodes + 1) * np.pi / 4
    depth, medium = 0.7, Medium(1.0, quantity="stress")
    rho = depth * np.tan(slant)
    step = rho * depth / np.cos(slant) ** 2 * weights * np.pi / 4
    azimuth = (np.arange(16) + 0.5) * 2 * np.pi / 16
    at = rho[:, None, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    felt = disc_load(at, depth, [[0, 0, 0.3, -0.2, 0.5]], [1.0], profile, medium, [LAM])
    assert (felt * step[:, None, None]).sum((0, 1)) * np.pi / 8 == pytest.approx((-0.3, 0.2, -0.5), rel=1e-9)
    far = np.array([[300.0, 100.0], [0.0, 500.0]])
    spread = disc_load(far, 400.0, [[0, 0, 0.3, -0.2, 0.5]], [1.0], profile, medium, [LAM])
    assert spread == pytest.approx(point_load(far, 400.0, [[0, 0, 0.3, -0.2, 0.5]], medium), rel=2e-5)
    gone = disc_load(far, 400.0, [[0, 0, 0.3, -0.2, 0.5]], [0.0], profile, medium, [LAM])
    assert gone == pytest.approx(point_load(far, 400.0, [[0, 0, 0.3, -0.2, 0.5]], medium), rel=1e-12)


def test_other_peoples_hertz() -> None:
    hertz = pytest.importorskip(
        "ContactMechanics.ReferenceSolutions.Hertz",
        reason="ContactMechanics is not installed: pip install ContactMechanics",
    )
    medium = Medium(2.4e6, 0.3)
    for force, radius in ((1e-3, 1e-3), (0.5, 5e-3)):
        a, p0 = hertz.radius_and_pressure(force, radius, medium.contact_modulus)
        assert hertz_radius(force, radius, medium.contact_modulus) == pytest.approx(a, rel=1e-12)
        delta = hertz.penetration(force, radius, medium.contact_modulus)
        assert hertz_indentation(force, radius, medium.contact_modulus) == pytest.approx(delta, rel=1e-12)
        assert hertz_force(delta, radius, medium.contact_modulus) == pytest.approx(force, rel=1e-12)
        r, z = np.array([0.0, 0.4, 0.9, 1.5, 2.5]), np.array([0.1, 0.5, 1.0, 2.0, 0.7])
        _, _, theirs, shear = hertz.stress(r, z, poisson=0.3)
        ours = np.array(
            [
                disc_load((x * a, 0.0), y * a, [[0, 0, 0, 0, force]], [a], HERTZ, Medium(2.4e6, 0.3, "stress"))
                for x, y in zip(r, z, strict=True)
            ]
        )
        assert ours[:, 2] == pytest.approx(theirs * p0, rel=1e-9)
        assert np.abs(ours[:, 0]) == pytest.approx(np.abs(shear * p0), rel=1e-9, abs=1e-9 * p0)


def test_a_round_tip_is_hertz_when_shallow_and_never_wider_than_itself() -> None:
    star, tip = 3.2e6, 50e-6
    force = np.array([0.0, 1e-12, 1e-9, 1e-6, 1e-4, 0.02, 1.0, 1e6])
    radius = round_tip_radius(force, tip, star)
    assert radius[0] == 0
    assert radius[1:4] == pytest.approx(hertz_radius(force[1:4], tip, star), rel=2e-2)
    assert radius[1] == pytest.approx(hertz_radius(force[1], tip, star), rel=1e-7)
    assert (np.diff(radius) >= 0).all()
    assert radius.max() <= tip
    lam = radius[3:6] / tip
    assert star * tip**2 * ((lam**2 + 1) * np.arctanh(lam) - lam) == pytest.approx(force[3:6], rel=1e-9)
    # the weight is that of p: at the shallow end Hertz' own, and 1 in sum everywhere
    theta, step = np.polynomial.legendre.leggauss(400)
    theta, step = theta * np.pi / 2, step * np.pi / 2
    for value in (0.0, 1e-6, 0.01, 0.5, 0.99):
        assert (ROUND_TIP.weight(theta, np.full(400, value)) * step).sum() == pytest.approx(1, abs=1e-5)
    assert ROUND_TIP.weight(theta, np.full(400, 0.002)) == pytest.approx(HERTZ.weight(theta, theta), abs=1e-5)


def test_a_twist_is_many_turning_points() -> None:
    # q = 3 M r / (4 pi sqrt(1 - r^2)) around the axis
    places, share = on_a_disc(lambda r: 3 * r / (4 * np.pi * np.sqrt(1 - r * r)))
    r = np.hypot(*places.T)
    forces = share[:, None] * np.stack([-places[:, 1], places[:, 0], np.zeros(len(r))], axis=-1) / r[:, None]
    assert (places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]).sum() == pytest.approx(1, rel=1e-9)
    at = random.uniform(-2, 2, (20, 2))
    for nu, quantity in ((0.5, "strain"), (0.2, "strain"), (0.2, "stress")):
        medium = Medium(2.0, nu, quantity)  # type: ignore[arg-type]  # a loop
        wanted = point_load(at, 0.6, np.concatenate([places + np.array((0.1, 0.2)), forces], axis=1), medium)
        got = disc_load(at, 0.6, [[0.1, 0.2, 0, 0, 0, 1.0]], [1.0], HERTZ, medium)
        assert np.abs(got - wanted).max() < 1e-10 * np.abs(wanted).max()


def test_wrong_circles_are_refused() -> None:
    load = [[0, 0, 0, 0, 1]]
    with pytest.raises(InputError, match="at most 100"):
        disc_load((0, 0), 1e-6, load, [1e-3], HERTZ, Medium(1.0))
    with pytest.raises(InputError, match="radii of 0 or more"):
        disc_load((0, 0), 1e-3, load, [-1.0], HERTZ, Medium(1.0))
    with pytest.raises(InputError, match="tip radius"):
        round_tip_radius(1.0, 0.0, 1.0)


def test_waves_right_under_a_circle_are_as_good_as_far_from_it() -> None:
    near, far = np.array([3e-3]), np.array([3e-3, 60.0])  # distances far off ask for many more waves
    medium, radius = Medium(1.0, 0.5, "stress", 1.0), np.array([0.1])
    one, other = (layer(rho, radius, HERTZ, radius, medium, 0.95)[:, 0] for rho in (near, far))
    assert np.abs(one - other).max() < 1e-9 * np.abs(other).max()
