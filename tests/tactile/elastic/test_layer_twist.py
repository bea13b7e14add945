"""Twists on a layer: against a traction found by energy, the rigid turn, the half-space and a thin cover."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.layer_contact import WIDEST
from tactile.elastic.layer_twist import layer_twist
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.summation import field_at
from tests.oracles.elastic.torsion import turned

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("accuracy", (1e-4, 1e-7))
@pytest.mark.parametrize("radius", (0.3, 1.0, 4.0))
@pytest.mark.parametrize("depth", (0.3, 1.0))
def test_a_twist_is_felt_as_its_rigid_turn_of_the_layer(radius: float, depth: float, accuracy: float) -> None:
    medium = Medium(3.0, thickness=1.0)  # shear modulus 1
    contact = MovingContact(0, Indenter("flat_punch", radius), [(0.0, 0, 0, 0, 0, 0.0, 2.0)])
    rho = np.linspace(0, radius + 2, 60)
    at = np.stack([0 * rho, rho], axis=-1)
    got = field_at(at, depth, contact.loads(np.zeros(1), depth, medium), medium, accuracy=accuracy)[0]
    true = 2 * turned(radius, rho, depth)
    assert np.abs(true).max() > 0
    assert got[:, 0] == pytest.approx(-true, abs=max(accuracy, 3e-6) * np.abs(true).max())
    assert got[:, 1:] == pytest.approx(0, abs=1e-9)


def test_poissons_ratio_does_not_enter() -> None:
    at = np.array([[0.4, 0.7], [1.5, 0.2]])
    felt = []
    for nu in (0.2, 0.5):
        medium = Medium(2 * (1 + nu), nu, thickness=1.0)
        contact = MovingContact(0, Indenter("disc", 1.0), [(0.0, 0, 0, 0, 0, 0.0, 1.0)])
        felt.append(field_at(at, 0.5, contact.loads(np.zeros(1), 0.5, medium), medium)[0])
    assert felt[0] == pytest.approx(felt[1], rel=2e-4)


def test_on_a_thick_layer_it_is_the_half_spaces_and_on_a_thin_one_it_grows_with_the_radius() -> None:
    theta = np.linspace(0, 1.5, 11)
    profile = layer_twist()
    assert profile.weight(theta, np.zeros(11)) == pytest.approx(HERTZ.weight(theta, np.zeros(11)), rel=1e-14)
    assert profile.weight(theta, np.full(11, 1e-3)) == pytest.approx(HERTZ.weight(theta, np.zeros(11)), rel=1e-8)
    # a traction that grows like r is the slope of 2 (1 - r^2) / pi, of line weight 8 / 3 pi cos(theta)^4
    thin = profile.weight(theta, np.full(11, WIDEST))
    assert thin == pytest.approx(8 / (3 * np.pi) * np.cos(theta) ** 4, abs=0.03)
    # the plain circle's is far from it
    assert np.abs(thin - HERTZ.weight(theta, np.zeros(11))).max() > 0.08


def test_twists_wider_than_the_tables_are_refused() -> None:
    contact = MovingContact(0, Indenter("disc", 0.021), [(0.0, 0, 0, 0, 0, 1.0, 1e-3)])
    with pytest.raises(InputError, match=r"twisted contact 21 mm in radius on a cover of 1 mm; at most 20 thicknesses"):
        contact.loads(np.zeros(1), 1e-3, Medium(1e6, thickness=1e-3))
    assert contact.loads(np.zeros(1), 1e-3, Medium(1e6)).twists[0].profile is HERTZ
