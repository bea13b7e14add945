"""Very wide circles on a layer, integrated one by one: against rings of point loads, and as fine as is asked for."""

import numpy as np
import pytest

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS, FORCE, PLACE
from tactile.elastic.gauss import gauss
from tactile.elastic.layer_discs import add_layer
from tactile.elastic.layer_loads import layer_term
from tactile.elastic.medium import Felt, Medium
from tactile.elastic.profiles import HERTZ, UNIFORM
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.scene.scene import Scene

AT = np.array([[0.0, 0.0], [0.3, -1.1], [4.0, 3.0], [6.1, -1.0], [9.0, 0.5]])


def rings(wide: float, hertz: bool) -> tuple[Floats, Floats]:
    """Places (n, 2) and shares (n,) of points that stand for a uniform or Hertz' pressure on a circle."""
    nodes, weights = gauss(40)
    root, turn = (nodes + 1) / 2, np.arange(120) * np.pi / 60
    # r^2 / a^2 = 1 - root^2 takes the pressure's root away
    radius = wide * np.sqrt(1 - root**2) if hertz else wide * np.sqrt(root)
    share = weights / 2 * (3 * root**2 if hertz else 1.0)
    at = radius[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return at.reshape(-1, 2), np.repeat(share / len(turn), len(turn))


@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.parametrize(("hertz", "thickness", "nu"), [(True, 2.0, 0.5), (False, 1.0, 0.5), (True, 1.0, 0.3)])
def test_what_a_layer_adds_is_the_sum_over_points(hertz: bool, thickness: float, nu: float, quantity: Felt) -> None:
    wide, medium, load = 6.0, Medium(3.0, nu, quantity, thickness), np.array([0.2, -0.1, 0.5, -0.3, 1.0])
    out = np.zeros((1, len(AT), 3))
    add_layer(out, AT, 1.0, load[None, None], np.full((1, 1), wide), HERTZ if hertz else UNIFORM, np.inf, medium)
    places, shares = rings(wide, hertz)
    rows = np.empty((len(places), COLUMNS))
    rows[:, PLACE], rows[:, FORCE] = places + load[PLACE], shares[:, None] * load[FORCE]
    wanted = layer_term(AT, 1.0, np.broadcast_to(rows, (len(AT), *rows.shape)), thickness, medium)
    assert out[0] == pytest.approx(wanted, abs=2e-6 * float(np.abs(wanted).max()))


@pytest.mark.parametrize(
    ("shape", "radius", "force", "by"), [("sphere", 0.2, 300.0, 2.0), ("flat_punch", 2e-3, 0.01, 1.0)]
)
def test_a_scene_of_the_finest_accuracy_has_very_wide_contacts(
    shape: str, radius: float, force: float, by: float
) -> None:
    # the sphere touches over 27 depths; tables for it would take minutes, and then not be fine enough
    array, path = TaxelArray("c", 2, 2, 8e-4, 2e-4), [(0.0, 1e-5, 0, force / 10, 0, force)]
    body = MovingContact(0, Indenter(shape, radius), path)  # type: ignore[arg-type]  # one of its names
    felt = [
        next(Scene("s", 10.0, 0.1, 2.4e6, (array,), (), (body,), [FiniteThickness(by * 2e-4)], accuracy=accuracy)
             .batches(0)).values
        for accuracy in (0.0, 1e-4)
    ]  # fmt: skip
    assert np.abs(felt[0] - felt[1]).max() < 1e-4 * np.abs(felt[0]).max()


def test_a_twist_of_a_very_wide_circle_is_the_tables() -> None:
    array, path = TaxelArray("c", 2, 3, 8e-4, 2e-4), [(0.0, 1e-4, 2e-4, 0, 0, 1.0, 1e-4)]
    body = MovingContact(0, Indenter("flat_punch", 1.3e-3), path)
    felt = [
        next(Scene("s", 10.0, 0.1, 2.4e6, (array,), (), (body,), [FiniteThickness(4e-4)], accuracy=accuracy)
             .batches(0)).values
        for accuracy in (0.0, 1e-4)
    ]  # fmt: skip
    for part in (0, 1, 2):
        assert np.abs(felt[0] - felt[1])[..., part].max() < 1e-4 * np.abs(felt[0]).max()
