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
from tactile.simulator.contacts.shapes.layer_law import LayerLaw
from tactile.simulator.summation import field_at
from tests.oracles.elastic.bonded import PeriodicLayer

pytestmark = pytest.mark.slow

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
        self.touching(wide)

    def touching(self, wide: float) -> None:
        """Press or let go until it touches over that radius."""
        deep = float(layer_contact("paraboloid", self.layer.nu).indentation(np.array(wide))) / R
        if wide not in self._pressures:
            gap = (self.x**2 + self.x[:, None] ** 2) / (2 * R)
            self._pressures[wide] = self.layer.pressed(gap, deep, 1e-4)
        self.pressure = self._pressures[wide]
        self.force = float(self.pressure.sum()) * self.layer.cell

    @cached_property
    def _pressures(self) -> dict[float, Floats]:
        return {}

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
        found = self.felt(path, depth)
        true = self.part(self.layer.strain(shear, np.zeros(self.layer.shape), depth), depth)
        return float(np.abs(found - true).max() / np.abs(true).max()), float(np.abs(true).max())

    def felt(self, path: Floats, depth: float) -> Floats:
        """What is felt of the pulls at the end of a path, without what presses."""
        inside = np.abs(self.x) < self.wide + 2 * depth
        at = np.stack(np.meshgrid(self.x[inside], self.x[inside]), axis=-1)
        ways = path, np.array([(0.0, 0, 0, 0, 0, path[-1, -1])])
        contacts = [MovingContact(0, Indenter("sphere", R), way, MU) for way in ways]
        pulled, pressed = (
            field_at(at, depth, contact.loads(contact.path[-1:, 0], depth, self.medium), self.medium)[0]
            for contact in contacts
        )
        return np.asarray(pulled - pressed)

    def part(self, values: Floats, depth: float) -> Floats:
        """Values of all cells where these are felt."""
        inside = np.abs(self.x) < self.wide + 2 * depth
        return np.asarray(values[np.ix_(inside, inside)])


@pytest.mark.parametrize("depth", (0.3, 1.0))
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


@pytest.mark.parametrize(
    "ways",
    [
        [(0.3 + 0.1 * n, 0.05 * (n + 1)) for n in range(8)],  # pulled and pressed at once, in small steps
        [(0.6, 0.15), (0.8, 0.15), (1.0, 0.15)],  # pulled, then pressed harder
        [(0.6, 0.3), (1.0, 0.3), (1.0, 0.7)],  # and pulled again
        [(1.0, 0.2), (0.95, 0.2), (0.9, 0.2), (0.85, 0.2)],  # let go of a little
    ],
)
def test_a_pull_is_felt_as_the_layer_slips_while_the_force_changes(ways: list[tuple[float, float]]) -> None:
    last = solved(2.0, 0.5)
    far, slipped, loads = last.slides(), np.zeros((2, *last.layer.shape)), []
    for part, way in ways:
        last.touching(2.0 * part)
        shear, slipped = last.moved(way * far, slipped)
        loads.append((last.carried(shear), last.force))
    path = [(0.0, 0, 0, 0, 0, loads[0][1]), *((n + 1.0, 0, 0, pull, 0, force) for n, (pull, force) in enumerate(loads))]
    true = last.layer.strain(shear, 0 * last.pressure, 0.5)
    got = last.felt(np.array(path), 0.5)
    most = last.layer.strain(np.stack([MU * last.pressure, 0 * last.pressure]), 0 * last.pressure, 0.5)
    last.touching(2.0)
    # a share of what is felt when all of it slides; rings kept by their force alone are 3 to 9 % off
    assert np.abs(got - last.part(true, 0.5)).max() < 0.012 * np.abs(most).max()


def test_rings_keep_their_places_when_the_force_changes() -> None:
    medium = Medium(1.0, thickness=1.0)
    pressed, ends = LayerLaw("sphere", "paraboloid", R, medium), np.array([[0.3, 0.7, 1.0, 0.0]])
    shares = np.array([[[0.2, 0.1], [-0.5, 0.3], [1.0, 0.0], [0.0, 0.0]]])
    for wide, same in ((0.01, True), (2.0, False)):
        force = float(pressed.force_on(np.array(wide)))
        for factor in (1.4, 0.8):
            to = np.array([force * factor])
            rings, found = pressed.carried_over(ends * force, shares, to)
            plain = np.minimum(ends * force, to)
            kept = np.diff(plain, axis=1, prepend=0)[0, :3, None] * shares[0, :3]
            kept = np.diff(rings, axis=1, prepend=0)[0, :3, None] * found[0, :3] - kept
            assert (np.abs(rings - plain).max() < 2e-3 * force) == same
            if factor > 1:
                assert np.abs(kept).max() < 1e-5 * force
            assert np.hypot(*found[0].T).max() <= 1 + 1e-12
            assert (rings[0, :3] <= to).all()
            assert rings[0, 3] == 0
    same_rings, same_shares = pressed.carried_over(ends * force, shares, np.array([force]))
    assert (same_rings == ends * force).all()
    assert (same_shares == shares).all()


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
