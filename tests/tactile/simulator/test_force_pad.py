"""Force taxels of scenes: forces on squares against double integrals of the pressure, sums against the loads."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import dblquad

from cnnsim.support import Floats, InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.profiles import FLAT_PUNCH, HERTZ, ROUND_TIP, UNIFORM, Profile
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.mounting.misplacement import Misplacement
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.force_pad import quadrant_share
from tactile.simulator.scene.scene import Scene
from tactile.wire.packets import emulated_description, packets
from tests.kits.touch.small_scene import SPHERE, made, values

PAD = TaxelArray("pad", 4, 3, 2e-3, 0.0, (1e-3, 0.0), "force")


def read(*contacts: Any, effects: tuple[Any, ...] = (), array: TaxelArray = PAD) -> Floats:
    loads = [one for one in contacts if isinstance(one, MovingLoad)]
    others = [one for one in contacts if not isinstance(one, MovingLoad)]
    return values(Scene("s", 10.0, 0.2, 2.4e6, (array,), loads, others, effects))[0]


def test_a_point_is_read_by_the_taxel_under_it() -> None:
    x, y = PAD.positions()[2, 1] + (0.9e-3, -0.9e-3)
    wanted = np.zeros((4, 3, 3))
    wanted[2, 1] = 0.1, -0.2, 0.5
    assert read(MovingLoad(0, [(0, x, y, 0.1, -0.2, 0.5)])) == pytest.approx(wanted, abs=1e-15)
    narrow = read(MovingLoad(0, [(0, x, y, 0.1, -0.2, 0.5)]), effects=(TaxelArea(1e-3),))
    assert not narrow.any()  # between the taxels


def test_the_pressure_of_a_ball_is_integrated_over_each_square() -> None:
    middle, force = (0.7e-3, 0.4e-3), 0.8
    pressed = MovingContact(0, Indenter("sphere", 8e-3), [(0, *middle, 0.2, 0.0, force)])
    got = read(pressed)
    scene = Scene("s", 10.0, 0.2, 2.4e6, (PAD,), (), (pressed,))
    radius = float(scene.skin.field(0, np.zeros(1)).loads.discs[0].radii[0, 0])
    assert 1e-3 < radius < 2e-3  # on several taxels

    def pressure(y: float, x: float) -> float:
        inside = 1 - ((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / radius**2
        return 1.5 * force / (np.pi * radius**2) * float(np.sqrt(max(inside, 0)))

    for row, col in ((2, 1), (1, 2)):
        x, y = PAD.positions()[row, col]
        wanted = dblquad(pressure, x - 1e-3, x + 1e-3, y - 1e-3, y + 1e-3, epsabs=1e-5)[0]
        assert got[row, col, 2] == pytest.approx(wanted, abs=1e-4 * force)
        assert got[row, col, 0] == pytest.approx(got[row, col, 2] / 4, abs=1e-12)
    assert got.sum(axis=(0, 1)) == pytest.approx((0.2, 0, force), rel=1e-9)


@pytest.mark.parametrize(
    ("profile", "lam", "within"),
    [
        (FLAT_PUNCH, 0.0, lambda r: 1 - np.sqrt(1 - r * r)),
        (UNIFORM, 0.0, lambda r: r * r),
        (HERTZ, 0.0, lambda r: 1 - (1 - r * r) ** 1.5),
        (ROUND_TIP, 1e-2, lambda r: 1 - (1 - r * r) ** 1.5),  # shallow: Hertz
    ],
)
def test_quadrants_of_known_pressures(profile: Profile, lam: float, within: Any) -> None:
    """A half is left of the middle; a strip |x| < h by the chord of each ring."""
    share = quadrant_share(np.array([-1, -0.3, 0, 0.3, 1.0]), np.array([-1, 0, 1.0]), profile, lam)
    assert share[2] == pytest.approx([0, 1 - share[2, 3], 0.5, share[2, 3], 1], abs=1e-12)
    assert share[1] == pytest.approx(share[2] / 2, abs=1e-12)
    r = np.sin(np.linspace(0, np.pi / 2, 20001))
    arc = np.where(r > 0.3, 2 / np.pi * np.arcsin(0.3 / np.maximum(r, 0.3)), 1.0)
    strip = np.diff(within(r)) @ ((arc[1:] + arc[:-1]) / 2)
    assert share[2, 3] - share[2, 1] == pytest.approx(strip, abs=2e-4)


def test_a_turned_pad_reads_along_its_own_axes() -> None:
    turned = Misplacement(0.0, 0.0, np.pi / 2)  # its x axis lies along y
    square = TaxelArray("pad", 3, 3, 2e-3, 0.0, quantity="force")
    got = read(MovingLoad(0, [(0, 0.0, 2e-3, 0.0, 0.3, 0.5)]), effects=(turned,), array=square)
    assert got[1, 2] == pytest.approx((0.3, 0, 0.5), abs=1e-12)
    assert got.sum(axis=(0, 1)) == pytest.approx((0.3, 0, 0.5), abs=1e-12)


def test_a_scene_file_of_force_reads_the_load_in_every_frame() -> None:
    cover = {"youngs_modulus_mpa": 2.4, "quantity": "force"}
    scene = made(cover=cover, contact=[SPHERE])
    assert values(scene).sum(axis=(1, 2))[:, 2] == pytest.approx(0.5)
    assert scene.unit(0) == pytest.approx(2.4e6 * 1.5e-3**2)
    sent = packets(description := emulated_description("papillarray", scene), scene, False)
    decoder = description.wire.decoder(description.options)
    readings = [reading for packet in sent for reading in decoder.feed(packet[1])]
    assert np.ravel(readings[-1].values) == pytest.approx(values(scene)[-1].ravel(), rel=1e-6)
    twisted = {**SPHERE, "twist": True, "path": [[0.0, 0, 0, 0, 0, 0.5, 0.1]]}
    with pytest.raises(InputError, match="a twisted contact on force taxels; forces alone wanted"):
        values(made(cover=cover, contact=[twisted]))
    with pytest.raises(InputError, match="of force on bumps"):
        made(cover={**cover, "kind": "bump"}, contact=[SPHERE])
