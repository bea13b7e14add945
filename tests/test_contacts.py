"""Contacts over time: force and depth, friction with its memory, twist, drawn textures, maps; all of them add."""

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.errors import InputError
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_radius
from tactile.simulator.contacts import MovingContact, MovingLoad
from tactile.simulator.drawn import Drawn
from tactile.simulator.field import felt
from tactile.simulator.friction import Slip, load_to, untouched
from tactile.simulator.indenter import Indenter
from tactile.simulator.maps import TractionMap
from tactile.simulator.materials import PRESETS, Material
from tactile.simulator.pressed import together
from tactile.simulator.scene import Contact
from tactile.texture import Texture

MU = 0.6
RUBBER = Medium(2.4e6)
random = np.random.default_rng(2)


def loaded(*steps: tuple[float, float, float]) -> Slip:
    """A contact that went through (normal, Q, R) one after the other."""
    slip = untouched(MU)
    for normal, q, r in steps:
        slip = load_to(slip, normal, np.array([q, r]))
    return slip


@pytest.mark.parametrize("share", (0.0, 0.1, 0.5, 0.9, 0.999))
def test_cattaneo_mindlin_stick_radius(share: float) -> None:
    # c / a = (1 - Q / mu P)^(1/3); forces go with the cube of radii
    for turn in (0.0, 2.0):
        pull = share * MU * 2.0
        slip = loaded((2.0, 0, 0), (2.0, pull * np.cos(turn), pull * np.sin(turn)))
        assert np.cbrt(slip.sticks / 2.0) == pytest.approx((1 - share) ** (1 / 3), rel=1e-12)
        assert slip.force == pytest.approx((pull * np.cos(turn), pull * np.sin(turn)), abs=1e-14)
        assert not slip.slipping


def test_traction_of_cattaneo_mindlin() -> None:
    slip = loaded((2.0, 0, 0), (2.0, 0.7, 0))
    at, force = slip.terms()
    radius = hertz_radius(at, 1e-3, RUBBER.contact_modulus)
    r = np.linspace(0, 0.999 * radius[-1], 50)
    traction = sum(
        1.5 * f[0] / (np.pi * a * a) * np.sqrt(np.maximum(1 - (r / a) ** 2, 0))
        for a, f in zip(radius, force, strict=True)
    )
    a, c = radius[-1], radius[-1] * (1 - 0.7 / (MU * 2)) ** (1 / 3)
    p0 = 1.5 * 2.0 / (np.pi * a * a)
    wanted = MU * p0 * (np.sqrt(1 - (r / a) ** 2) - c / a * np.sqrt(np.maximum(1 - (r / c) ** 2, 0)))
    assert traction == pytest.approx(wanted, rel=1e-9, abs=1e-9 * p0)
    limit = MU * p0 * np.sqrt(1 - (r / a) ** 2)
    assert (traction <= limit * (1 + 1e-12)).all()  # slips in the ring, sticks inside


def test_unloading_follows_mindlin_and_deresiewicz() -> None:
    # after Q1 the shear falls to Q: a ring slips back to c with (c / a)^3 = 1 - (Q1 - Q) / (2 mu P)
    limit = MU * 2.0
    for back in (0.5, 0.0, -0.3):
        slip = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0), (2.0, back * limit, 0))
        assert slip.sticks / 2.0 == pytest.approx(1 - (0.8 - back) / 2, rel=1e-12)
    # a full cycle closes, and what happened inside it is forgotten
    once = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0))
    cycle = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0), (2.0, 0.1, 0), (2.0, 0.5, 0), (2.0, 0.8 * limit, 0))
    for one, other in zip(once.terms(), cycle.terms(), strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12)


def test_pressing_harder_while_shear_grows_sticks_everywhere() -> None:
    # Mindlin and Deresiewicz: no slip while dQ < mu dP, whatever the steps
    slip = untouched(MU)
    for k in range(1, 11):
        slip = load_to(slip, k * 0.1, np.array([k * 0.1 * MU * 0.9, 0.0]))
        assert slip.sticks == pytest.approx(k * 0.1)
    assert np.hypot(*slip.shares.T) == pytest.approx(np.full(len(slip.shares), 0.9))
    one = loaded((1.0, MU * 0.9, 0))
    assert one.force == pytest.approx(slip.force)


def test_full_slip_and_forgetting() -> None:
    assert loaded((2.0, 5.0, 0)).slipping
    assert loaded((2.0, 5.0, 0)).force == pytest.approx((MU * 2.0, 0))
    assert loaded((2.0, 0.5, 0), (0.0, 0.0, 0)).ends.size == 0
    assert loaded((2.0, 0.5, 0), (0.0, 0.1, 0)).slipping
    frictionless = load_to(untouched(0.0), 1.0, np.array([0.1, 0.0]))
    assert not frictionless.force.any()
    with pytest.raises(InputError, match="friction coefficient -1"):
        untouched(-1.0)


def test_any_history_carries_what_is_asked_within_coulombs_limit() -> None:
    for _ in range(30):
        slip = untouched(MU)
        for _ in range(60):
            normal = random.uniform(0, 3)
            size, turn = random.uniform(0, 1.2) * MU * normal, random.uniform(0, 2 * np.pi)
            asked = size * np.array([np.cos(turn), np.sin(turn)])
            slip = load_to(slip, normal, asked)
            if size < MU * normal:
                assert slip.force == pytest.approx(asked, abs=1e-12)
            else:
                assert np.hypot(*slip.force) == pytest.approx(MU * normal)
            assert (np.hypot(*slip.shares.T) <= 1 + 1e-9).all()
            assert (np.diff(slip.ends, prepend=0.0) > 0).all()
            assert 0 <= slip.sticks <= normal + 1e-12
            assert slip.terms()[1].sum(axis=0) == pytest.approx(slip.force, abs=1e-12)


def at_rest(
    indenter: Indenter, row: tuple[float, ...], friction: float | None = None, by_depth: bool = False
) -> MovingContact:
    return MovingContact(0, indenter, np.array([(0.0, *row)]), friction, by_depth)


def feel(contact: MovingContact, at: NDArray[np.float64], depth: float = 5e-4) -> NDArray[np.float64]:
    return felt(at, depth, contact.pressed(np.array([1.0]), depth, RUBBER), RUBBER)[0]


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
    pressed = contact.pressed(np.array([1.0]), 5e-4, RUBBER)
    total = pressed.loads[0, :, 2:].sum(0) + sum(disc.loads[0, :, 2:].sum(0) for disc in pressed.discs)
    assert total == pytest.approx(row[2:5], rel=1e-12)
    assert pressed.totals[0, 0] == pytest.approx(row[:5])
    far = np.array([[0.02, 0.01], [-0.01, 0.03]])
    point = feel(at_rest(Indenter(), row), far, 0.03)
    assert feel(contact, far, 0.03) == pytest.approx(point, rel=1e-3)
    near = np.array([[1e-4, -2e-4]])
    if indenter.shape != "point":
        assert abs(feel(contact, near)[0, 2]) < abs(feel(at_rest(Indenter(), row), near)[0, 2])


def test_friction_limits_what_a_contact_carries_and_changes_how_it_is_spread() -> None:
    row = (0.0, 0.0, 0.02, 0.0, 0.02, 0.0)
    for indenter in (Indenter("sphere", 2e-3), Indenter("edge", 0, 1e-3)):
        pressed = at_rest(indenter, row, 0.5).pressed(np.array([1.0]), 5e-4, RUBBER)
        assert pressed.totals[0, 0, 2] == pytest.approx(0.01)
    mild = (0.0, 0.0, 0.004, 0.0, 0.02, 0.0)
    at = np.array([[0.0, 0.0], [3e-4, 0.0]])
    sphere, path = Indenter("sphere", 2e-3), np.array([(0.0, 0, 0, 0, 0, 0.02, 0), (1.0, *mild)])
    spread, ring = (feel(MovingContact(0, sphere, path, friction), at, 1e-4) for friction in (None, 0.5))
    assert feel(at_rest(sphere, mild, 0.5), at, 1e-4) == pytest.approx(spread, rel=1e-9)  # both at once: no slip
    assert abs(ring[0, 0]) < 0.9 * abs(spread[0, 0])  # the stuck middle carries less of the shear
    assert ring[0, 2] == pytest.approx(spread[0, 2], rel=1e-12)


def test_history_along_a_path_remembers() -> None:
    # out and back: at the same forces the traction differs by what slipped
    path = np.array([(t, 0, 0, q, 0, 0.02, 0) for t, q in ((0, 0), (1, 0.008), (2, 0.0), (3, 0.008))])
    contact = MovingContact(0, Indenter("sphere", 2e-3), path, 0.5)
    out, back, again = contact.slip_at(np.array([0.5, 1.5, 2.5]), RUBBER)
    assert out.force == pytest.approx(back.force, abs=1e-15)
    assert out.sticks == pytest.approx(0.02 * (1 - 0.004 / 0.01))
    assert back.sticks == pytest.approx(0.02 * (1 - 0.004 / 0.02))  # the ring that slips back starts at the rim
    assert len(back.ends) > len(out.ends)
    assert again.force == pytest.approx((0.004, 0), abs=1e-15)
    whole, piece = (
        contact.pressed(np.linspace(0, 3, 31), 5e-4, RUBBER),
        contact.pressed(np.linspace(0, 3, 31)[20:22], 5e-4, RUBBER),
    )
    at = np.array([[1e-4, 0.0]])
    assert np.array_equal(felt(at, 5e-4, whole, RUBBER)[20:22], felt(at, 5e-4, piece, RUBBER))  # however it is cut
    late = MovingContact(0, Indenter("sphere", 2e-3), path + np.eye(7)[0], 0.5)
    assert not felt(at, 5e-4, late.pressed(np.array([0.5, 4.5]), 5e-4, RUBBER), RUBBER).any()


def test_given_depth_is_the_force_that_hertz_asks() -> None:
    for indenter, force in (
        (Indenter("sphere", 2e-3), 4 / 3 * RUBBER.contact_modulus * np.sqrt(2e-3) * (1e-5) ** 1.5),
        (Indenter("flat_punch", 1e-4), 2 * 1e-4 * RUBBER.contact_modulus * 1e-5),
    ):
        pressed = at_rest(indenter, (0, 0, 0, 0, 1e-5, 0), by_depth=True).pressed(np.array([1.0]), 5e-4, RUBBER)
        assert pressed.totals[0, 0, 4] == pytest.approx(force)
    needle = Indenter("needle", 50e-6)
    depths = np.array([-1e-6, 0.0, 1e-9, 1e-6, 75e-6, 1e-3])
    forces = needle.force_at(depths, RUBBER)
    assert forces[:2].tolist() == [0, 0]
    lam = needle.contact_radius(forces[2:5], RUBBER) / 50e-6
    assert 50e-6 * lam * np.arctanh(lam) == pytest.approx(depths[2:5], rel=1e-5)
    with pytest.raises(InputError, match="indentation given for a point"):
        at_rest(Indenter(), (0, 0, 0, 0, 1e-5, 0), by_depth=True).pressed(np.array([1.0]), 5e-4, RUBBER)


def test_a_twist_is_limited_by_friction_and_adds() -> None:
    at = np.array([[2e-4, 0.0], [0.0, 3e-4]])
    gentle, hard = (at_rest(Indenter("sphere", 2e-3), (0, 0, 0, 0, 0.02, m), 0.5) for m in (1e-7, 1e-3))
    still = at_rest(Indenter("sphere", 2e-3), (0, 0, 0, 0, 0.02, 0), 0.5)
    swirl = feel(gentle, at) - feel(still, at)
    assert swirl[0, 1] < 0 < swirl[1, 0]  # turning x to y drags the skin along: sigma = -q at the surface
    assert np.abs(swirl[:, 2]).max() < 1e-15
    most = 3 * np.pi / 16 * 0.5 * 0.02 * hertz_radius(0.02, 2e-3, RUBBER.contact_modulus)
    assert hard.pressed(np.array([1.0]), 5e-4, RUBBER).twists[0].twists[0, 0, 2] == pytest.approx(most)


def test_contacts_add() -> None:
    times = np.array([0.0, 0.5])
    parts: list[Contact] = [
        MovingLoad(0, np.array([(0.0, 1e-4, 0, 0.01, 0, 0.02), (1.0, 2e-4, 0, 0.01, 0, 0.03)])),
        at_rest(Indenter("sphere", 2e-3), (0, 1e-4, 2e-3, 0, 0.02, 1e-7), 0.5),
        at_rest(Indenter("edge", 0, 1e-3), (3e-4, 0, 0, 0, 0.02, 0)),
        TractionMap(0, np.array([(0, 0, 1, 2, 3.0), (1e-4, 0, 0, 0, 1.0)]), np.array([(0.0, 0.01), (1.0, 0.02)])),
    ]
    at = random.uniform(-5e-4, 5e-4, (3, 4, 2))
    single = [part.pressed(times, 5e-4, RUBBER) for part in parts]
    whole = felt(at, 5e-4, together(single, 2), RUBBER)
    assert np.abs(whole - sum(felt(at, 5e-4, one, RUBBER) for one in single)).max() < 1e-13 * np.abs(whole).max()
    shift, factor = np.full((2, 4, 2), (1e-5, -2e-5)), np.full((2, 4), 1.5)
    moved = felt(at, 5e-4, together(single, 2).moved(shift, factor), RUBBER)
    wanted = 1.5 * felt(at - (1e-5, -2e-5), 5e-4, together(single, 2), RUBBER)
    assert np.abs(moved - wanted).max() < 1e-12 * np.abs(wanted).max()
    assert not felt(at, 5e-4, together([], 2), RUBBER).any()


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


def drawn(material: str, seed: int = 1, force: float = 0.1, duration: float = 2.5) -> Drawn:
    return Drawn(0, (0.0, 0.0), PRESETS[material], 0.0, duration, 5e-3, 0.5, force, 1e3, seed)


@pytest.mark.parametrize("name", PRESETS)
def test_profiles_have_the_statistics_they_declare(name: str) -> None:
    material = PRESETS[name]
    way = np.linspace(0, 2.0, 400_001)
    height = material.profile(way, np.random.default_rng(4))
    assert abs(height.mean()) < 0.01
    assert height.std() == pytest.approx(np.hypot(material.regular, material.irregular), rel=0.03)


@pytest.mark.parametrize("name", PRESETS)
def test_a_drawn_object_sticks_and_slips_within_its_friction(name: str) -> None:
    material, times = PRESETS[name], np.linspace(0, 2.5, 20_001)
    shear, normal = drawn(name).series(times)
    assert (shear <= material.static * normal + 1e-12).all()
    late = times > 0.2
    ratio = shear[late & (normal > 0.03)] / normal[late & (normal > 0.03)]
    assert 0.3 * material.kinetic < ratio.mean() < material.static
    drops = np.diff(shear) < -0.5 * (material.static - material.kinetic) * normal[1:]
    assert drops.sum() > 5  # slips
    assert normal[late].mean() == pytest.approx(0.1, rel=0.1)
    before, after = drawn(name).series(np.array([-0.1, 2.6]))
    assert not before.any()
    assert not after.any()
    pressed = drawn(name).pressed(times, 1e-3, RUBBER)
    assert np.arctan2(pressed.totals[500, 0, 3], pressed.totals[500, 0, 2]) == pytest.approx(0.5)


def test_the_four_materials_are_told_apart_by_friction_and_roughness() -> None:
    # the paper's figures of merit (19), (20): T = 128 frames of 15 ms, many profiles, different forces
    clouds = {}
    for name in PRESETS:
        points = []
        for seed in range(12):
            times = np.linspace(0.3, 0.3 + 127 * 0.015, 128)
            shear, normal = drawn(name, seed, 0.05 + 0.01 * seed).series(times)
            texture = Texture(128, 0.0)
            for s, f in zip(shear, normal, strict=True):
                figures = texture.update(np.array([[[s * np.cos(0.5), s * np.sin(0.5), -max(f, 1e-3)]]]))
            points.append((figures.friction[0, 0], figures.roughness[0, 0]))
        clouds[name] = np.array(points)
    names = list(PRESETS)
    for k, a in enumerate(names):
        for b in names[k + 1 :]:
            apart = np.abs(clouds[a].mean(0) - clouds[b].mean(0))
            spread = clouds[a].std(0) + clouds[b].std(0)
            assert (apart > spread).any(), (a, b, clouds[a].mean(0), clouds[b].mean(0), spread)


def test_drawing_without_stick_slip_slides_and_wrong_objects_are_refused() -> None:
    smooth = Material("ice", 1e-3, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.1)
    shear, normal = Drawn(0, (0, 0), smooth, 0.0, 2.0, 5e-3, 0.0, 0.1, 1e3).series(np.linspace(0.1, 2, 50))
    assert normal == pytest.approx(np.full(50, 0.1))
    assert shear == pytest.approx(np.full(50, 0.01), rel=0.02)
    still, _ = Drawn(0, (0, 0), smooth, 0.0, 2.0, 0.0, 0.0, 0.1, 1e3).series(np.array([1.0]))
    assert still[0] == 0
    with pytest.raises(InputError, match="stop after start"):
        Drawn(0, (0, 0), smooth, 2.0, 2.0, 5e-3, 0.0, 0.1, 1e3)
    with pytest.raises(InputError, match="steps to draw"):
        Drawn(0, (0, 0), PRESETS["rasp"], 0.0, 1e6, 1.0, 0.0, 0.1, 1e3)
    with pytest.raises(InputError, match="kinetic <= static"):
        Material("m", 1e-3, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.2)
    with pytest.raises(InputError, match="lengths"):
        Material("m", 0.0, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.1)
