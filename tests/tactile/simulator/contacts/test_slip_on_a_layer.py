"""Friction on a thin cover: what is felt of contacts that partly slip, against slip solved cell by cell."""

from functools import cached_property

import numpy as np
import pytest
from scipy import fft

from cnnsim.support import Floats
from tactile.elastic.layer_contact import layer_contact
from tactile.elastic.layer_slip import layer_slip
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.field import field_at
from tests.oracles.elastic.bonded import PeriodicLayer

MU, R = 0.5, 200.0
MARGIN = 8.0
"""Thicknesses to the next image, which adds 1 % of what is felt over the base at 6."""


class Pressed:
    """A sphere pressed onto a layer of thickness and modulus 1 until it touches over a radius ``wide``."""

    def __init__(self, wide: float, nu: float, cells: int = 10) -> None:
        step = wide / cells
        side = fft.next_fast_len(int(np.ceil((2 * wide + MARGIN) / step)))
        self.layer = PeriodicLayer((side, side), (step, step), nu)
        self.x = (np.arange(side) - side // 2) * step
        self.medium, self.wide = Medium(1.0, nu, thickness=1.0), wide
        deep = float(layer_contact("paraboloid", nu).indentation(np.array(wide))) / R
        gap = (self.x**2 + self.x[:, None] ** 2) / (2 * R)
        self.pressure = self.layer.pressed(gap, deep, 1e-4)
        self.force = float(self.pressure.sum()) * self.layer.cell

    @cached_property
    def pulled(self) -> dict[float, Floats]:
        """Tractions after it is moved by a part of what would have all of it slide."""
        return {part: self.moved(part * self.slides())[0] for part in (0.25, 0.5)}

    def slides(self) -> float:
        """How far the surface is dragged along where all of it slides."""
        most = self.layer.dragged(np.stack([MU * self.pressure, 0 * self.pressure]))
        return float(most[0].max())

    def moved(self, way: float, before: Floats | None = None) -> tuple[Floats, Floats]:
        """Tractions after it is moved that far, and by what has slipped by then, ``before`` that of earlier ways."""
        aim = np.zeros((2, *self.layer.shape))
        aim[0] = way
        shear = self.layer.slipped(MU * self.pressure, aim if before is None else aim - before)
        return shear, aim - self.layer.dragged(shear)

    def carried(self, shear: Floats) -> float:
        return float(shear[0].sum()) * self.layer.cell

    def off(self, shear: Floats, pulls: list[float], depth: float) -> tuple[float, float]:
        """Largest error of what is felt of the shear at the end of some pulls, as a share of the largest, and that."""
        path = np.array([(float(t), 0, 0, pull, 0, self.force) for t, pull in enumerate([0.0, *pulls])])
        contact = MovingContact(0, Indenter("sphere", R), path, MU)
        part = np.abs(self.x) < self.wide + 2 * depth
        at = np.stack(np.meshgrid(self.x[part], self.x[part]), axis=-1)

        def felt(t: float) -> Floats:
            return field_at(at, depth, contact.loads(np.array([t]), depth, self.medium), self.medium)[0]

        found = felt(float(len(pulls))) - felt(0.0)
        true = self.layer.strain(shear, np.zeros(self.layer.shape), depth)[np.ix_(part, part)]
        return float(np.abs(found - true).max() / np.abs(true).max()), float(np.abs(true).max())


@pytest.mark.parametrize("depth", (0.3, 0.7, 1.0))
@pytest.mark.parametrize(
    ("wide", "nu", "most"),
    [(0.4, 0.5, 0.02), (1.0, 0.3, 0.015), (1.0, 0.5, 0.02), (2.0, 0.3, 0.02), (2.0, 0.5, 0.03), (4.0, 0.5, 0.03)],
)
def test_a_pull_is_felt_as_the_layer_slips(wide: float, nu: float, most: float, depth: float) -> None:
    pressed = solved(wide, nu)
    for shear in pressed.pulled.values():  # the lighter one leaves half the force and more to what sticks
        share = pressed.carried(shear) / (MU * pressed.force)
        assert 0.3 < share < 0.8
        assert pressed.off(shear, [pressed.carried(shear)], depth)[0] < most


def solved(wide: float, nu: float, known: dict[tuple[float, float], Pressed] = {}) -> Pressed:  # noqa: B006 - kept
    if (wide, nu) not in known:
        known[wide, nu] = Pressed(wide, nu)
    return known[wide, nu]


@pytest.mark.parametrize(("wide", "nu", "most"), [(1.0, 0.5, 0.02), (2.0, 0.3, 0.02), (2.0, 0.5, 0.02)])
def test_a_pull_that_turns_back_is_felt_as_the_layer_slips_back(wide: float, nu: float, most: float) -> None:
    pressed = solved(wide, nu)
    far = pressed.slides()
    shear, slipped = pressed.moved(0.6 * far)
    back, _ = pressed.moved(0.1 * far, slipped)
    pulls = [pressed.carried(one) for one in (shear, back)]
    assert pulls[1] < 0.3 * pulls[0]
    size = float(np.abs(pressed.layer.strain(shear, 0 * pressed.pressure, 0.5)).max())
    error, left = pressed.off(back, pulls, 0.5)
    assert error * left < most * size


def test_what_sticks_on_a_layer_is_the_half_spaces_where_the_contact_is_narrow() -> None:
    for nu in (0.3, 0.5):
        slip = layer_slip(layer_contact("paraboloid", nu))
        share = np.array([0.05, 0.3, 0.7, 1.0])
        assert slip.radius(np.full(4, 0.01), share) == pytest.approx(0.01 * np.cbrt(share), rel=2e-3)
        theta = np.linspace(0, 1.5, 9)
        plain = HERTZ.weight(theta, np.zeros(9))
        assert slip.profile.weight(theta, np.full(9, 0.01)) == pytest.approx(plain, rel=1e-4, abs=1e-6)
        assert slip.profile.turned is not None
        assert slip.profile.turned(theta, np.full(9, 0.01)) == pytest.approx(0, abs=1e-5)
        wide = slip.radius(np.full(4, 2.0), share) / 2.0
        assert (wide[:3] < 0.996 * np.cbrt(share[:3])).all()
        assert wide[3] == pytest.approx(1.0, abs=1e-6)
