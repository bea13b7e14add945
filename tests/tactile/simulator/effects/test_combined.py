"""Effects in combination: a layer under spheres, twists and wide taxels is the superposition of its point loads."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import j0

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.layer import transfer
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.profiles import HERTZ
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.mounting import STILL, Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tests.oracles.elastic.layer import layer_load

Z = 1e-3
PAD = TaxelArray("pad", 3, 5, 1e-3, Z)


def affected(contact: Any, *effects: Any, array: TaxelArray = PAD, accuracy: float = 1e-4) -> Field:
    scene = Scene("s", 10.0, 0.1, 2.4e6, (array,), (), (contact,), effects, accuracy=accuracy)
    (field,) = scene.affected(scene.skin.fields(0, scene.skin.chunks(0)), "field", scene.effects, 0)
    return field


def superposed(field: Field, around: int = 48, along: int = 40) -> NDArray[np.float64]:
    """The field of the first frame as a sum of point loads on the layer, over circles of Hertz' pressure and areas."""
    nodes, weights = np.polynomial.legendre.leggauss(along)
    t, step = (nodes + 1) * np.pi / 4, weights * np.pi / 4
    r, share = np.sin(t), 1.5 / np.pi * np.cos(t) ** 2 * np.sin(t) * step * 2 * np.pi / around
    azimuth = (np.arange(around) + 0.5) * 2 * np.pi / around
    unit = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    points = []
    for disc in field.loads.discs:
        for load, radius in zip(disc.loads[0], disc.radii[0], strict=True):
            places = load[:2] + radius * r[:, None, None] * unit
            forces = np.broadcast_to(share[:, None, None] * load[2:], (along, around, 3))
            points.append(np.concatenate([places, forces], axis=-1).reshape(-1, 5))
    for twist in field.loads.twists:
        (x, y, *_, torque), radius = twist.loads[0, 0], twist.radii[0, 0]
        # q = 3 M r / (4 pi a^3 sqrt(a^2 - r^2)), along (-s, c)
        force = 3 * torque / (4 * np.pi * radius) * r**2 * step * 2 * np.pi / around
        places = (x, y) + radius * r[:, None, None] * unit
        swirl = force[:, None, None] * np.stack([-unit[:, 1], unit[:, 0], 0 * azimuth], axis=-1)
        points.append(np.concatenate([places, swirl], axis=-1).reshape(-1, 5))
    at, weight = np.zeros((1, 2)), np.ones(1)
    if field.taxels.width:
        nodes, weights = np.polynomial.legendre.leggauss(12)
        at = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) * field.taxels.width / 2
        weight = np.outer(weights, weights).ravel() / 4
    loads = np.concatenate([*points, field.loads.points[0]])
    felt = np.stack([
        layer_load(field.taxels.places + step, field.taxels.depth, loads, field.medium.thickness, field.medium)
        for step in at
    ])  # fmt: skip
    return np.tensordot(weight, felt, 1)


@dataclass(frozen=True)
class Given:
    """Loads as they are, under Hertz' pressure whatever the cover."""

    given: Loads
    finger: int = 0

    def loads(self, times: Any, depth: float, medium: Medium, rig: Rig = STILL) -> Loads:
        discs = tuple(replace(disc, profile=HERTZ, unit=np.inf) for disc in self.given.discs)
        return replace(self.given, discs=discs)


def off(field: Field) -> float:
    wanted = superposed(field)
    return float(np.abs(field.values[0] - wanted).max() / np.abs(wanted).max())


def sphere(force: float, friction: float | None = None, torque: float = 0.0, shear: float = 0.0) -> MovingContact:
    path = [(0.0, 1e-4, 2e-4, shear, -shear / 2, force, torque)]
    return MovingContact(0, Indenter("sphere", 5e-3), np.array(path), friction)


def test_the_pressure_of_a_layer_is_felt_by_all_its_waves() -> None:
    field = affected(sphere(2.0), FiniteThickness(1.02 * Z))
    (disc,) = field.loads.discs
    radius, thickness = disc.radii[0, 0] / Z, field.medium.thickness
    nodes, weights = np.polynomial.legendre.leggauss(400)
    k, step = (nodes + 1) * 15, weights * 15
    theta = (nodes + 1) * np.pi / 4
    weight = disc.profile.weight(theta, np.full(400, radius * Z / thickness)) * weights * np.pi / 2
    spread = np.cos(np.outer(k, radius * np.sin(theta))) @ weight
    wave = transfer(k / Z, Z, thickness, field.medium).normal * spread * k * step / (2 * np.pi * Z**2)
    rho = np.hypot(*np.moveaxis(PAD.positions() - disc.loads[0, 0, :2], -1, 0)) / Z
    wanted = 2.0 * j0(rho[..., None] * k) @ wave
    assert np.abs(field.values[0, ..., 2] - wanted).max() < 1e-4 * np.abs(field.values).max()


@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.parametrize("times", (1.0, 1.02, 2.0))
def test_a_wide_contact_on_a_layer_is_many_points(times: float, quantity: FieldQuantity) -> None:
    array = replace(PAD, quantity=quantity)
    for contact in (sphere(2.0), sphere(2.0, 0.5, 1e-4, 0.3)):
        loads = affected(contact, FiniteThickness(times * Z), array=array).loads
        assert loads.discs[0].radii.max() > Z  # not a point at all
        assert off(affected(Given(loads), FiniteThickness(times * Z), array=array)) < 1e-4


def test_a_taxel_area_at_the_bottom_of_a_thin_cover() -> None:
    array = TaxelArray("chip", 2, 2, 4e-4, 2e-4, quantity="stress")
    needle = MovingContact(0, Indenter(), np.array([(0.0, 1e-4, 5e-5, 2e-3, 1e-3, 0.02)]))
    field = affected(needle, FiniteThickness(2e-4), TaxelArea(300e-6), array=array)
    assert off(field) < 2e-4
    # the same in any order, and the tip is spread before the area is averaged
    tip = affected(needle, FiniteTip(50e-6), FiniteThickness(2e-4), TaxelArea(300e-6), array=array)
    named = [
        ("taxel_area", TaxelArea(300e-6)),
        ("finite_thickness", FiniteThickness(2e-4)),
        ("finite_tip", FiniteTip()),
    ]
    turned = affected(needle, *named, array=array)
    assert np.array_equal(tip.values, turned.values)
    assert 0.01 < np.abs(tip.values - field.values).max() / np.abs(field.values).max() < 0.5


def test_maps_feel_the_layer() -> None:
    cells = np.array([(x * 1e-3, y * 1e-3, 0.01, 0.0, 0.02) for x in range(-2, 3) for y in range(-1, 2)])
    pressed = TractionMap(0, cells, np.array([(0.0, 1.0), (1.0, 2.0)]))
    assert off(affected(pressed, FiniteThickness(1.1 * Z))) < 1e-4
    assert off(affected(pressed, FiniteThickness(1.1 * Z), accuracy=1e-6)) < 1e-6


def test_accuracy_is_a_choice() -> None:
    exact = affected(sphere(0.5, 0.5, 0.0, 0.1), accuracy=0.0).values
    for accuracy in (1e-3, 1e-4, 1e-5, 1e-6):
        got = affected(sphere(0.5, 0.5, 0.0, 0.1), accuracy=accuracy).values
        assert np.abs(got - exact).max() < accuracy * np.abs(exact).max()
        assert (got != exact).any() == (accuracy >= 1e-5)  # integrated one by one below
    layer = FiniteThickness(1.5 * Z)
    fine, quick = (affected(sphere(0.5), layer, accuracy=accuracy) for accuracy in (0.0, 1e-4))
    assert np.abs(fine.values - quick.values).max() < 1e-4 * np.abs(fine.values).max()
    medium = Medium(2.4e6, thickness=1.5 * Z)
    assert fine.medium == medium


@pytest.mark.parametrize("thickness", (np.inf, 1.5 * Z))
def test_circles_of_many_depths_keep_the_accuracy(thickness: float) -> None:
    ball = MovingContact(0, Indenter("sphere", 0.2), np.array([(0.0, 1e-4, 2e-4, 1.0, -0.5, 60.0, 1e-3)]), 0.5)
    layer = [FiniteThickness(thickness)]
    exact = affected(ball, *layer, accuracy=0.0)
    assert exact.loads.discs[0].radii.max() > 6.5 * Z
    for accuracy in (1e-3, 1e-4):
        got = affected(ball, *layer, accuracy=accuracy).values
        assert np.abs(got - exact.values).max() < accuracy * np.abs(exact.values).max()


def test_a_wide_taxel_alone_keeps_the_accuracy_where_little_is_felt() -> None:
    chip = TaxelArray("chip", 1, 1, Z, Z)
    beside = MovingContact(0, Indenter(), np.array([(0.0, 0.0, 1e-4, 0.05, 0.0, 0.15)]))
    exact = superposed(affected(beside, FiniteThickness(Z), TaxelArea(Z), array=chip))
    for accuracy in (1e-4, 1e-6):
        got = affected(beside, FiniteThickness(Z), TaxelArea(Z), array=chip, accuracy=accuracy).values[0]
        assert np.abs(got - exact).max() < accuracy * np.abs(exact).max()
    with pytest.raises(InputError, match=r"30 mm wide and 1 mm deep to 0.0001 of the peak; \d.* or more"):
        affected(beside, TaxelArea(30e-3), array=replace(chip, pitch=0.03)).values  # noqa: B018 - computed when asked for


def test_accuracies_that_cannot_be_kept_are_refused_with_both_numbers() -> None:
    for accuracy in (1e-8, 1e-9, -1e-4, float("nan"), 0.5):
        with pytest.raises(InputError, match=f"accuracy {accuracy:g}; from 1e-07 to 0.1 of the peak wanted"):
            affected(sphere(0.5), accuracy=accuracy)
    assert affected(sphere(0.5), accuracy=1e-7).accuracy == 1e-7
