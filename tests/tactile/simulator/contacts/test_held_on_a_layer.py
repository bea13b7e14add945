"""Contacts that a rig holds over a thin cover: forces and stiffness against rigid bodies pressed onto a grid."""

import numpy as np
import pytest
from scipy import fft

from cnnsim.support import Floats
from tactile.core.loads import F
from tactile.elastic.layer_contact import layer_contact
from tactile.elastic.lines import cylinder_half_width
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig, at_a_point
from tests.oracles.elastic.bonded import PeriodicLayer


def room(width: float, length: float, nu: float) -> tuple[PeriodicLayer, Floats, Floats]:
    """A layer with room around a contact so wide (to either side) and long, and its cells' places."""
    across, count = width / 14, max(20, int(np.ceil(length / min(0.15, width / 3))))
    along = length / count
    cols, rows = (fft.next_fast_len(int(size / step)) for size, step in ((2 * width + 6, across), (length + 6, along)))
    x, y = (np.arange(cols) - cols // 2) * across, (np.arange(rows) - (count - 1) / 2) * along
    return PeriodicLayer((rows, cols), (along, across), nu), x, y


@pytest.mark.parametrize(("radius", "length", "nu"), [(1.0, 2.0, 0.3), (0.4, 2.0, 0.4), (2.0, 6.0, 0.5)])
def test_a_held_cylinder_is_as_stiff_as_a_rigid_one_of_its_length(radius: float, length: float, nu: float) -> None:
    deep = 0.05
    layer, x, y = room(1.1 * np.sqrt(2 * radius * deep), length, nu)
    gap = np.where(np.abs(y[:, None]) < length / 2, x**2 / (2 * radius), 1e3)
    found = [layer.pressed(gap, deep * by, 1e-4) for by in (0.97, 1.0, 1.03)]
    forces = [float(one.sum()) * layer.cell for one in found]
    body, medium = Indenter("cylinder", radius, length), Medium(1.0, nu, thickness=1.0)
    # ends that are sharp press harder than the product's, which are a little rounded
    assert float(body.indentation(np.array([forces[1]]), medium)[0]) == pytest.approx(deep, rel=0.02)
    for rise, force in zip((-0.03 * deep, 0.03 * deep), forces[::2], strict=True):
        held = float(body.held_factor(np.array([forces[1]]), np.array([rise]), medium, 50e-6)[0])
        assert held - 1 == pytest.approx(force / forces[1] - 1, rel=0.04)
    wide = float(np.count_nonzero(found[1][np.abs(y).argmin()])) * (x[1] - x[0]) / 2
    assert float(cylinder_half_width(forces[1], length, radius, medium)) == pytest.approx(wide, rel=0.1)
    edge = Indenter("edge", 0.0, length)  # as round as the rig's needle
    assert edge.held_factor(np.array([forces[1]]), np.array([0.03 * deep]), medium, radius) == pytest.approx(held)


@pytest.mark.parametrize("nu", (0.3, 0.5))
@pytest.mark.parametrize(("shape", "wide"), [("sphere", 0.3), ("sphere", 1.0), ("sphere", 2.0), ("needle", 0.5),
                                             ("flat_punch", 0.5)])  # fmt: skip
def test_a_held_round_body_is_as_stiff_as_a_rigid_one(shape: str, wide: float, nu: float) -> None:
    step = wide / 20
    side = fft.next_fast_len(int((2 * wide + 7) / step))
    layer, x = PeriodicLayer((side, side), (step, step), nu), (np.arange(side) - side // 2) * step
    square, medium = x**2 + x[:, None] ** 2, Medium(1.0, nu, thickness=1.0)
    radius = {"sphere": 50.0, "needle": 2 * wide, "flat_punch": wide}[shape]
    body = Indenter(shape, radius)
    gap = np.minimum(square, radius**2)
    gap = {"sphere": square / (2 * radius), "needle": radius - np.sqrt(radius**2 - gap),
           "flat_punch": np.where(square < radius**2, 0.0, 1e3)}[shape]  # fmt: skip
    deep = {"sphere": wide**2 / 50 * 0.9, "needle": wide / 4, "flat_punch": 1e-3}[shape]
    forces = [float(layer.pressed(gap, deep * by, 1e-4).sum()) * layer.cell for by in (1.0, 1.05)]
    held = float(body.held_factor(np.array([forces[0]]), np.array([0.05 * deep]), medium, 50e-6)[0])
    # cells at the rim of a flat end make it a little wider or narrower
    assert float(body.indentation(np.array([forces[0]]), medium)[0]) == pytest.approx(deep, rel=0.03)
    assert held - 1 == pytest.approx(forces[1] / forces[0] - 1, rel=0.025)
    if shape == "sphere":  # so is the tip that holds a contact at a point
        tip = Indenter().held_factor(np.array([forces[0]]), np.array([0.05 * deep]), medium, radius)
        assert float(tip[0]) == pytest.approx(held, rel=1e-6)


def test_a_tip_holds_any_force_and_lets_go() -> None:
    layer, point = Medium(1.0, 0.5, thickness=1.0), Indenter()
    # F ~ delta^1.5 where the layer is not felt; nearly delta^3, past the tables, too, where it is thin
    law = layer_contact("paraboloid", 0.5)
    for wide, power, off in ((1e-3, 1.5, 1e-2), (law.widest, 3.0, 6e-2)):
        force, deep = (float(of(np.array(wide))) for of in (law.force, law.indentation))
        for by in (1.0, 4.0):
            given = np.array([by**power * force / 0.75]), np.array([by * deep])
            assert float(point.held_factor(*given, layer, 1.0)[0]) == pytest.approx(2**power, rel=off)
    forces, rises = np.array([0.1, 0.1, 0.1, 0.0, -0.1]), np.array([0.0, -1e3, 1e-9, 1.0, 1.0])
    still, off, slightly, light, pulled = point.held_factor(forces, rises, layer, 1.0).tolist()
    assert (still, off, light, pulled) == (1.0, 0.0, 1.0, 1.0)
    assert 0 < slightly - 1 < 1e-7


@pytest.mark.parametrize(("radius", "nu"), [(0.6, 0.5), (2.0, 0.4), (20.0, 0.5)])
def test_a_tip_spreads_a_point_as_a_needle_does(radius: float, nu: float) -> None:
    layer, force = Medium(1.0, nu, thickness=1.0), np.array([[0.0], [0.05], [1.0]]) * radius**2
    rows = np.zeros((3, 5))
    rows[:, F] = force[:, 0]
    (spread,) = at_a_point(rows, layer, Rig(tip=radius)).discs
    body = Indenter("needle", radius)
    assert spread.radii == pytest.approx(body.contact_radius(force, layer), rel=1e-9)
    assert (spread.profile, spread.unit) == body.round.profile(layer)
    # under any force, and no wider than itself
    rows[:, F] = 1e6
    (spread,) = at_a_point(rows, layer, Rig(tip=radius)).discs
    assert (0.99 * radius < spread.radii).all()
    assert (spread.radii <= radius).all()
