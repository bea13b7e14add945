"""Contacts that are pulled: they lift off, or stick as Johnson, Kendall and Roberts have it."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.adhesion import Adhesion
from tactile.simulator.scene.model_range import out_of_range
from tactile.simulator.scene.scene import ModelRangeWarning, Scene

RUBBER, WORK, R = Medium(2.4e6), 0.05, 5e-3
PULL_OFF = 1.5 * np.pi * WORK * R
STICKY = Rig(work=WORK)
TIMES = np.linspace(0, 3, 3001)


def pressed(
    *pushes: float, friction: float | None = None, by_depth: bool = False, shape: str = "sphere"
) -> MovingContact:
    path = np.array([(t, 0, 0, 1e-4, 0, push) for t, push in enumerate(pushes)])
    body = Indenter(shape, R, 1e-2)
    return MovingContact(0, body, path, friction, by_depth)


@pytest.mark.parametrize("shape", ("sphere", "needle", "flat_punch", "disc", "edge", "cylinder"))
def test_a_dry_body_lifts_off(shape: str) -> None:
    loads = pressed(0.5, -0.5, 0.5, shape=shape).loads(TIMES, 1e-3, RUBBER)
    force = loads.totals[:, 0, 2:]
    assert force[:, 2].min() == 0
    assert not force[(TIMES > 0.5) & (TIMES < 1.5)].any()
    spread = [disc.loads for disc in loads.discs] or [loads.points]
    assert min(part[..., 4].min() for part in spread) >= 0


def test_a_point_that_touches_lifts_off_and_a_load_may_pull() -> None:
    assert pressed(0.5, -0.5, shape="point").loads(TIMES, 1e-3, RUBBER).totals[:, 0, 4].min() == 0
    load = MovingLoad(0, [(t, 0, 0, 0, 0, push) for t, push in enumerate((0.5, -0.5))])
    assert load.loads(TIMES, 1e-3, RUBBER).totals[:, 0, 4].min() == pytest.approx(-0.5)


def test_a_sphere_sticks_until_it_snaps_off() -> None:
    loads = pressed(0.0, 0.01, -0.01, 0.01).loads(TIMES, 1e-3, RUBBER, STICKY)
    force = loads.totals[:, 0, 4]
    assert force.min() == pytest.approx(-PULL_OFF, rel=0.02)  # the last frame before
    snapped = 1 + (0.01 + PULL_OFF) / 0.02
    assert not force[(snapped + 2e-3 < TIMES) & (TIMES < 2.5)].any()
    assert force[TIMES > 2.51] == pytest.approx(-0.01 + 0.02 * (TIMES[TIMES > 2.51] - 2))  # and touches again
    (body, pull) = loads.discs
    assert body.radii[0, 0] == pytest.approx(np.cbrt(4.5 * np.pi * WORK * R**2 / RUBBER.contact_modulus), rel=1e-5)
    assert body.loads[..., 4].sum(1) + pull.loads[..., 4].sum(1) == pytest.approx(force, abs=1e-15)


def test_a_given_depth_pulls_too() -> None:
    force = pressed(0.0, 1e-5, -1e-5, by_depth=True).loads(TIMES, 1e-3, RUBBER, STICKY).totals[:, 0, 4]
    assert force[0] == pytest.approx(-8 / 9 * PULL_OFF, rel=1e-4)  # touching it draws itself in
    assert force.min() == pytest.approx(-PULL_OFF, rel=1e-3)
    # delta at the end of the stable branch: 3/4 cbrt(pi^2 w^2 R / E*^2)
    far = 0.75 * np.cbrt(np.pi**2 * WORK**2 * R / RUBBER.contact_modulus**2)
    snapped = 1 + (1e-5 + far) / 2e-5
    assert (force[np.abs(TIMES - snapped + 5e-3) < 2e-3] < 0).all()
    assert not force[snapped + 2e-3 < TIMES].any()


def test_a_flat_end_is_held_by_its_rim_and_no_work_is_no_adhesion() -> None:
    wanted = np.sqrt(8 * np.pi * RUBBER.contact_modulus * WORK * R**3)
    force = pressed(0.5, -2 * wanted, shape="flat_punch").loads(TIMES, 1e-3, RUBBER, STICKY).totals[:, 0, 4]
    assert force.min() == pytest.approx(-wanted, rel=0.01)
    weak = pressed(0.0, 0.01, 0.02, 0.0, friction=0.5).loads(TIMES, 1e-3, RUBBER, Rig(work=1e-12))
    dry = pressed(0.0, 0.01, 0.02, 0.0, friction=0.5).loads(TIMES, 1e-3, RUBBER)
    assert weak.totals == pytest.approx(dry.totals, abs=1e-8)


def test_a_cylinder_wider_than_its_cover_is_thick_presses_by_the_layers_law() -> None:
    lying, layer = Indenter("cylinder", 4e-2, 8e-2), replace(RUBBER, thickness=1e-3)
    wide = MovingContact(0, lying, np.array([(0.0, 0, 0, 0, 0, 2000.0)])).loads(np.zeros(1), 1e-3, layer)
    across = np.abs(wide.points[0, :, 1]).max()
    # rubber much thinner than the contact is wide: P / L = 2 E b^5 / (45 R h^3), b less 1.45 h at both rims
    thin = (2000.0 / 8e-2 * 45 * 4e-2 * 1e-9 / (2 * RUBBER.modulus)) ** 0.2
    assert across == pytest.approx(thin - 1.45e-3, rel=0.03)
    assert wide.points[0, :, 4].sum() == pytest.approx(2000.0)
    narrow = replace(lying, radius=4e-3)
    with pytest.raises(InputError, match=r"a cylinder 80 mm long sinks 3\.\d+ mm under 5e\+04 N into a cover of 1 mm"):
        MovingContact(0, narrow, np.array([(0.0, 0, 0, 0, 0, 5e4)])).loads(np.zeros(1), 1e-3, layer)
    with pytest.raises(InputError, match="over 40 thicknesses of the cover wide"):
        MovingContact(0, lying, np.array([(0.0, 0, 0, 0, 0, 1e7)])).loads(np.zeros(1), 1e-3, layer)


@pytest.mark.parametrize("by_depth", (True, False))
def test_a_needle_as_wide_as_itself_on_a_layer_is_refused_by_its_own_numbers(by_depth: bool) -> None:
    layer, needle = replace(RUBBER, thickness=2e-3), Indenter("needle", 5e-5)
    push = "1.5 mm deep; at most 0.34" if by_depth else "3 N; at most 0.1"
    with pytest.raises(InputError, match=f"a needle of radius 0.05 mm on a cover of 2 mm: {push}.*wide as the needle"):
        needle.force_at(np.array([1.5e-3]), layer) if by_depth else needle.contact_radius(np.array([3.0]), layer)
    with pytest.raises(InputError, match=r"mm deep; at most .* mm deep wanted, where its contact is 20 thicknesses"):
        Indenter("sphere", 1.0).force_at(np.array([9e-5]), replace(RUBBER, thickness=1e-4))


def test_a_rig_presses_by_each_contacts_own_law() -> None:
    def factor(body: Indenter, force: float, rise: float) -> float:
        return float(body.held_factor(np.array([force]), np.array([rise]), RUBBER, 50e-6)[0])

    # hertz' indentation of a sphere of 5 mm is cbrt(100) = 4.64 times less than that of one of 50 um
    sphere, point = factor(Indenter("sphere", R), 0.02, 1e-7) - 1, factor(Indenter(), 0.02, 1e-7) - 1
    assert sphere / point == pytest.approx(np.cbrt(100), rel=0.02)
    assert factor(Indenter("flat_punch", 1e-3), 0.02, 1e-7) == pytest.approx(1 + 1e-7 * 2e-3 * 3.2e6 / 0.02)
    for body in (Indenter("needle", 5e-4), Indenter("cylinder", 2e-3, 1e-2), Indenter("edge", 0, 1e-2)):
        assert factor(body, 0.02, 0.0) == pytest.approx(1, abs=1e-9)
        assert factor(body, 0.02, -1e-3) == pytest.approx(0, abs=1e-6)  # off the cover
        assert 1 < factor(body, 0.02, 1e-7) < factor(body, 0.02, 2e-7)
    trembling = Rig().with_move(lambda places: (np.zeros_like(places), np.full(len(places), 1e-5)), 50e-6)
    still, raised = (pressed(0.02, 0.02).loads(TIMES[:1], 1e-3, RUBBER, rig) for rig in (Rig(), trembling))
    grown = raised.totals[0, 0, 4] / still.totals[0, 0, 4]
    assert grown > 1.2
    assert raised.discs[0].radii[0, 0] / still.discs[0].radii[0, 0] == pytest.approx(np.cbrt(grown))


@pytest.mark.parametrize("nu", (0.5, 0.3))
@pytest.mark.parametrize("thickness", (np.inf, 1e-3))
@pytest.mark.parametrize("body", (Indenter("cylinder", 2e-3, 8e-3), Indenter("cylinder", 5e-5, 2e-2)))
def test_a_held_cylinder_is_pressed_until_it_sinks_in_as_deep(body: Indenter, thickness: float, nu: float) -> None:
    """From every force to every other, up to where it goes through the layer."""
    layer, force, deep = Medium(1e6, nu, thickness=thickness), np.geomspace(1e-9, 100, 60), np.empty(0)
    for one in force:
        with suppress(InputError):
            deep = np.append(deep, body.indentation(np.array([one]), layer))
    force = force[: len(deep)]
    assert (np.isinf(thickness) and deep[-1] > 1e-3) or deep[-1] > 0.5 * thickness
    rise = np.subtract.outer(deep, deep)  # [to, from]
    start = np.broadcast_to(force, rise.shape)
    found = body.held_factor(start.ravel(), rise.ravel(), layer, 50e-6).reshape(rise.shape) * start
    sunk = body.indentation(found.ravel(), layer).reshape(rise.shape)
    assert sunk == pytest.approx(np.broadcast_to(deep[:, None], rise.shape), rel=1e-11, abs=1e-15 * deep.max())


def test_a_held_cylinder_that_is_raised_beyond_what_its_length_allows_is_refused() -> None:
    short, force = Indenter("cylinder", 1e-2, 1e-3), np.array([0.1])
    assert short.held_factor(force, np.array([1e-6]), RUBBER, 50e-6) > 1
    with pytest.raises(
        InputError, match=r"a cylinder 1 mm long held 0\.\d+ mm deep; less wanted.*wider than it is long"
    ):
        short.held_factor(force, np.array([3e-4]), RUBBER, 50e-6)


@pytest.mark.parametrize("by_depth", (False, True))
def test_a_raised_cover_presses_what_sticks_by_the_law_of_what_sticks(by_depth: bool) -> None:
    stiff, rise = RUBBER.contact_modulus, 1e-7
    a = np.linspace(2e-4, 9e-4, 200001)  # F and delta of Johnson, Kendall and Roberts
    force = 4 * stiff * a**3 / (3 * R) - np.sqrt(8 * np.pi * stiff * WORK * a**3)
    deep = a**2 / R - np.sqrt(2 * np.pi * WORK * a / stiff)
    rig = STICKY.with_move(lambda places: (np.zeros_like(places), np.full(len(places), rise)), 50e-6)
    for wanted in (0.005, 0.02, 0.3):
        at = float(np.interp(wanted, force, deep))
        push = at if by_depth else wanted
        contact = pressed(push, push, by_depth=by_depth)
        still, raised = (contact.loads(TIMES[:1], 1e-3, RUBBER, one).totals[0, 0, 4] for one in (STICKY, rig))
        grown = np.interp(at + rise, deep, force) - wanted  # the dry law's would be 29, 16 and 4 % more
        assert raised - still == pytest.approx(grown, rel=2e-3)
    high = STICKY.with_move(lambda places: (np.zeros_like(places), np.full(len(places), 5e-5)), 50e-6)
    far = pressed(0.02, 0.02).loads(TIMES[:1], 1e-3, RUBBER, high).totals[0, 0, 4]
    assert far == pytest.approx(np.interp(np.interp(0.02, force, deep) + 5e-5, deep, force), rel=1e-4)


def test_the_range_of_two_alike_bodies_is_told_of_each() -> None:
    array = TaxelArray("pad", 2, 2, 1e-3, 1e-3)
    bodies = [pressed(0.0, 0.05, 0.0), pressed(0.05, -0.5), pressed(0.05, -0.5)]
    said = list(out_of_range(Scene("s", 100.0, 2.0, 2.4e6, (array,), (), bodies)))
    assert [line.split(",")[0] for line in said] == ["contact 2", "contact 3"]


def test_whoever_asks_for_frames_is_warned_once() -> None:
    array = TaxelArray("pad", 2, 2, 1e-3, 1e-3)
    scene = Scene("pulled", 100.0, 2.0, 2.4e6, (array,), (), (pressed(0.05, -0.5),))
    with pytest.warns(ModelRangeWarning, match="pulled: contact 1, a sphere: pulled with 0.5 N; a dry contact") as told:
        iter(scene)
    assert len(told) == 1
    assert told[0].filename == __file__
    for quiet in (scene, Scene("pressed", 100.0, 2.0, 2.4e6, (array,), (), (pressed(0.0, 0.05),))):
        iter(quiet)  # warnings are errors here
    fresh = replace(scene)
    assert "pulled with 0.5 N" in fresh.range_notes[0]  # who asks tells it himself
    iter(fresh)
    (note,) = fresh.with_effects([("adhesion", Adhesion())]).range_notes
    assert "pulled with 0.5 N; at most the pull-off force of 0.00118 N wanted" in note
    with pytest.warns(ModelRangeWarning, match="pulled with 0.5 N"):
        replace(scene).batches(0)
    with pytest.raises(InputError, match=r"strains to .*; at most 1 wanted"):
        iter(Scene("torn", 100.0, 1.0, 2.4e6, (array,), (MovingLoad(0, [(0.0, 5e-4, 5e-4, 0, 0, 20.0)]),)))
