"""Contacts over time: force and depth, friction, twist; all of them add."""

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_radius
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.summation import field_at

RUBBER = Medium(2.4e6)

random = np.random.default_rng(2)


def at_rest(
    indenter: Indenter, row: tuple[float, ...], friction: float | None = None, by_depth: bool = False
) -> MovingContact:
    return MovingContact(0, indenter, np.array([(0.0, *row)]), friction, by_depth)


def measure(contact: MovingContact, at: NDArray[np.float64], depth: float = 5e-4) -> NDArray[np.float64]:
    return field_at(at, depth, contact.loads(np.array([1.0]), depth, RUBBER), RUBBER)[0]


@pytest.mark.parametrize(
    "indenter",
    [
        Indenter("disc", 2e-4),
        Indenter("flat_punch", 2e-4),
        Indenter("sphere", 2e-3),
        Indenter("needle", 2e-4),
        Indenter("edge", 0, 1e-3, 0.3),
        Indenter("cylinder", 1e-3, 1e-3, 0.3),
        Indenter(),
    ],
    ids=lambda indenter: indenter.shape,
)
@pytest.mark.parametrize("friction", (None, 0.5))
def test_contacts_carry_their_load_and_are_points_from_afar(indenter: Indenter, friction: float | None) -> None:
    row = (1e-4, -2e-4, 4e-3, 3e-3, 0.02, 0.0)
    contact = at_rest(indenter, row, friction)
    loads = contact.loads(np.array([1.0]), 5e-4, RUBBER)
    total = loads.points[0, :, 2:].sum(0) + sum(disc.loads[0, :, 2:].sum(0) for disc in loads.discs)
    assert total == pytest.approx(row[2:5], rel=1e-12)
    assert loads.totals[0, 0] == pytest.approx(row[:5])
    far = np.array([[0.02, 0.01], [-0.01, 0.03]])
    point = measure(at_rest(Indenter(), row), far, 0.03)
    assert measure(contact, far, 0.03) == pytest.approx(point, rel=1e-3)
    near = np.array([[1e-4, -2e-4]])
    if indenter.shape != "point":
        assert abs(measure(contact, near)[0, 2]) < abs(measure(at_rest(Indenter(), row), near)[0, 2])


def test_friction_limits_what_a_contact_carries_and_changes_how_it_is_spread() -> None:
    row = (0.0, 0.0, 0.02, 0.0, 0.02, 0.0)
    for indenter in (Indenter("sphere", 2e-3), Indenter("edge", 0, 1e-3)):
        loads = at_rest(indenter, row, 0.5).loads(np.array([1.0]), 5e-4, RUBBER)
        assert loads.totals[0, 0, 2] == pytest.approx(0.01)
    mild = (0.0, 0.0, 0.004, 0.0, 0.02, 0.0)
    at = np.array([[0.0, 0.0], [3e-4, 0.0]])
    sphere, path = Indenter("sphere", 2e-3), np.array([(0.0, 0, 0, 0, 0, 0.02, 0), (1.0, *mild)])
    spread, ring = (measure(MovingContact(0, sphere, path, friction), at, 1e-4) for friction in (None, 0.5))
    assert measure(at_rest(sphere, mild, 0.5), at, 1e-4) == pytest.approx(spread, rel=1e-9)  # both at once: no slip
    assert abs(ring[0, 0]) < 0.9 * abs(spread[0, 0])  # the stuck middle carries less of the shear
    assert ring[0, 2] == pytest.approx(spread[0, 2], rel=1e-12)


def test_history_along_a_path_remembers() -> None:
    # out and back: at the same forces the traction differs by what slipped
    path = np.array([(t, 0, 0, q, 0, 0.02, 0) for t, q in ((0, 0), (1, 0.008), (2, 0.0), (3, 0.008))])
    contact = MovingContact(0, Indenter("sphere", 2e-3), path, 0.5)
    out, back, again = contact.friction_at(np.array([0.5, 1.5, 2.5]), RUBBER)
    assert out.force == pytest.approx(back.force, abs=1e-15)
    assert out.sticks == pytest.approx(0.02 * (1 - 0.004 / 0.01))
    assert back.sticks == pytest.approx(0.02 * (1 - 0.004 / 0.02))  # the ring that slips back starts at the rim
    assert len(back.ends) > len(out.ends)
    assert again.force == pytest.approx((0.004, 0), abs=1e-15)
    whole, piece = (
        contact.loads(np.linspace(0, 3, 31), 5e-4, RUBBER),
        contact.loads(np.linspace(0, 3, 31)[20:22], 5e-4, RUBBER),
    )
    at = np.array([[1e-4, 0.0]])
    assert np.array_equal(
        field_at(at, 5e-4, whole, RUBBER)[20:22], field_at(at, 5e-4, piece, RUBBER)
    )  # however it is cut
    late = MovingContact(0, Indenter("sphere", 2e-3), path + np.eye(7)[0], 0.5)
    assert not field_at(at, 5e-4, late.loads(np.array([0.5, 4.5]), 5e-4, RUBBER), RUBBER).any()


def test_given_depth_is_the_force_that_hertz_asks() -> None:
    for indenter, force in (
        (Indenter("sphere", 2e-3), 4 / 3 * RUBBER.contact_modulus * np.sqrt(2e-3) * (1e-5) ** 1.5),
        (Indenter("flat_punch", 1e-4), 2 * 1e-4 * RUBBER.contact_modulus * 1e-5),
    ):
        loads = at_rest(indenter, (0, 0, 0, 0, 1e-5, 0), by_depth=True).loads(np.array([1.0]), 5e-4, RUBBER)
        assert loads.totals[0, 0, 4] == pytest.approx(force)
    needle = Indenter("needle", 50e-6)
    depths = np.array([-1e-6, 0.0, 1e-9, 1e-6, 75e-6, 1e-3])
    forces = needle.force_at(depths, RUBBER)
    assert forces[:2].tolist() == [0, 0]
    lam = needle.contact_radius(forces[2:5], RUBBER) / 50e-6
    assert 50e-6 * lam * np.arctanh(lam) == pytest.approx(depths[2:5], rel=1e-5)
    with pytest.raises(InputError, match="indentation given for a point"):
        at_rest(Indenter(), (0, 0, 0, 0, 1e-5, 0), by_depth=True).loads(np.array([1.0]), 5e-4, RUBBER)


def test_a_twist_is_limited_by_friction_and_adds() -> None:
    at = np.array([[2e-4, 0.0], [0.0, 3e-4]])
    gentle, hard = (at_rest(Indenter("sphere", 2e-3), (0, 0, 0, 0, 0.02, m), 0.5) for m in (1e-7, 1e-3))
    still = at_rest(Indenter("sphere", 2e-3), (0, 0, 0, 0, 0.02, 0), 0.5)
    swirl = measure(gentle, at) - measure(still, at)
    assert swirl[0, 1] < 0 < swirl[1, 0]  # turning x to y drags the skin along: sigma = -q at the surface
    assert np.abs(swirl[:, 2]).max() < 1e-15
    most = 3 * np.pi / 16 * 0.5 * 0.02 * hertz_radius(0.02, 2e-3, RUBBER.contact_modulus)
    assert hard.loads(np.array([1.0]), 5e-4, RUBBER).twists[0].loads[0, 0, 5] == pytest.approx(most)


def test_wrong_indenters_are_refused() -> None:
    for wrong, message in (
        (("cube", 1.0), "shape 'cube'"),
        (("sphere", 0.0), "sphere of radius"),
        (("edge", 0.0, 0.0), "edge of length"),
    ):
        with pytest.raises(InputError, match=message):
            Indenter(*wrong)
    with pytest.raises(InputError, match="at least 1"):
        TractionMap(0, np.empty((0, 5)), np.array([(0.0, 1.0)]))


@pytest.mark.parametrize("shape", ("sphere", "flat_punch", "disc", "needle"))
@pytest.mark.parametrize("thickness", (np.inf, 1e-3))
def test_a_contact_slides_round_under_the_torque_of_its_own_pressure(shape: str, thickness: float) -> None:
    medium, force, mu = Medium(2.4e6, thickness=thickness), 2.0, 0.4
    body = Indenter(shape, 2e-2 if shape == "sphere" else 1e-3)
    contact = MovingContact(0, body, np.array([(0.0, 0, 0, 0, 0, force, 1.0)]), mu)
    loads = contact.loads(np.zeros(1), 1e-3, medium)
    (disc,), (twist,) = loads.discs, loads.twists
    radius = float(disc.radii[0, 0])
    # a pressure out of its line weight: that of flat ends of all radii t, which press at pi t / 4 in the mean
    lam = np.full(20001, radius / disc.unit)
    t = np.linspace(0, 1, 20001)
    angle = np.arcsin(np.minimum(t, 1 - 1e-9))
    line = disc.profile.weight(angle, lam) / np.cos(angle)
    mean = np.pi / 2 * (line[-1] - np.trapezoid(t**2, line))
    assert twist.loads[0, 0, 5] == pytest.approx(mu * force * mean * radius, rel=1e-3)
    if shape == "sphere" and thickness < np.inf:
        assert mean < 0.97 * 3 * np.pi / 16
