"""Bodies as height maps: against the exact laws of round bodies, on half-space and layer."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.elastic.rough_contact import RoughContact
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.height_surface import refined
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.pressed_map import press
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.scene.model_range import out_of_range
from tactile.simulator.scene.scene import Scene
from tactile.simulator.summation import field_at
from tests.oracles.elastic.layer import layered_load

R, SIDE = 5e-3, 41
PITCH = 4e-3 / SIDE
STEPS = (np.arange(SIDE) - SIDE // 2) * PITCH
BALL = (STEPS[None] ** 2 + STEPS[:, None] ** 2) / 2 / R


@pytest.mark.parametrize("thickness", (np.inf, 1.2e-3))
def test_a_ball_is_hertz_or_the_layers_law(thickness: float) -> None:
    medium, ball = Medium(2.4e6, thickness=thickness), Indenter("sphere", R)
    contact = RoughContact(BALL, PITCH, medium)
    for depth, bound in ((3e-5, 1e-2), (2e-4, 3e-3)):  # four and ten cells in a radius
        pressure = contact.pressed(depth)
        wanted = ball.force_at(np.array([depth]), medium)[0]
        assert pressure.sum() * PITCH**2 == pytest.approx(wanted, rel=bound)
        assert pressure.min() == 0
        left = depth - BALL - contact.sunk(pressure)  # the gap: closed where it presses, open elsewhere
        assert np.abs(left[pressure > 0]).max() < 2e-6 * depth
        assert left.max() < 2e-6 * depth
    at = np.array([[0.0, 0.0], [7e-4, 2e-4], [1.5e-3, 0.0]])
    path = [(0.0, 1e-4, 0, 0.05, -0.02, 0.5)]
    mapped = HeightMap(0, BALL, PITCH, np.array(path)).loads(np.zeros(1), 1e-3, medium)
    smooth = MovingContact(0, ball, np.array(path)).loads(np.zeros(1), 1e-3, medium)
    felt, known = (field_at(at, 1e-3, loads, medium)[0] for loads in (mapped, smooth))
    assert np.abs(felt - known).max() < 5e-3 * np.abs(known).max()


@pytest.mark.parametrize(("thickness", "deep"), ((1e-3, 1e-4), (3e-4, 3e-5)))
def test_a_ball_on_a_thin_cover_is_the_layers_law(thickness: float, deep: float) -> None:
    """Over incompressible covers of a sixth to a third of the contact's radius, which bulge beside it."""
    medium, radius, pitch = Medium(1e6, thickness=thickness), 30e-3, 1.4e-4
    along = (np.arange(81) - 40) * pitch
    solved = press((along**2 + along[:, None] ** 2) / 2 / radius, pitch, medium, deep, True)
    law = Indenter("sphere", radius)
    for depth, bound in (
        (deep / 4, 1e-2),
        (deep / 2, 6e-3),
        (deep, 6e-3),
    ):  # half as many cells in a radius in the first
        wanted = law.force_at(np.array([depth]), medium)[0]
        assert np.interp(depth, solved.deep, solved.force) == pytest.approx(wanted, rel=bound)
    spread = np.linalg.norm(solved.places[solved.forces[-1] > 0], axis=1).max()
    assert spread == pytest.approx(law.contact_radius(np.array([solved.force[-1]]), medium)[0], abs=1.5 * pitch)


def paraboloid(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((x**2 + y**2) / 2 / R)


def hills(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(paraboloid(x, y) / 4 + 4e-5 * (1 - np.cos(2094 * x) * np.cos(1848 * (y + 3e-4))))


def cells(count: int, pitch: float, off: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    along = (np.arange(count) - (count - 1) / 2) * pitch
    x, y = np.meshgrid(along + off * pitch, along - off * pitch)
    return x, y


@pytest.mark.parametrize("thickness", (np.inf, 1.2e-3))
@pytest.mark.parametrize(("body", "parts", "bound"), ((paraboloid, 2, 5e-3), (hills, 4, 1e-2)))
def test_a_smooth_body_in_coarse_cells_is_what_it_is_in_fine_ones(
    body: Callable[..., NDArray[np.float64]], parts: int, bound: float, thickness: float
) -> None:
    medium, depth, deep = Medium(2.4e6, thickness=thickness), 1e-3, 1e-4
    at = np.stack(np.meshgrid(np.linspace(-3e-3, 3e-3, 7), np.linspace(-3e-3, 3e-3, 7)), axis=-1)
    # cells that are each pressed as they are, a score in a contact's radius; the lowest place by a finer look
    x, y = cells(160, 5.2e-3 / 160, 0.0)
    lowest = float(body(*cells(1501, 5.2e-3 / 1501, 0.0)).min())
    fine = RoughContact(body(x, y), 5.2e-3 / 160, medium, lowest).pressed(deep) * (5.2e-3 / 160) ** 2
    force, on = float(fine.sum()), fine > 0
    for off in (0.0, 0.25, 0.5):  # of a cell: its lowest place lies on a middle or between them
        path = np.array([(0.0, off * depth / parts, -off * depth / parts, 0.2 * force, 0, deep)])
        heights = body(*cells(8 * parts + 1, depth / parts, off))
        by_depth = HeightMap(0, heights, depth / parts, path, None, True)
        loads = by_depth.loads(np.zeros(1), depth, medium)
        assert loads.totals[0, 0, 4] == pytest.approx(force, rel=bound)
        by_force = HeightMap(0, heights, depth / parts, path * (1, 1, 1, 1, 1, force / deep))
        known = np.stack([x[on], y[on], 0.2 * fine[on], 0 * fine[on], fine[on]], axis=-1)
        felt = [field_at(at, depth, one.loads(np.zeros(1), depth, medium), medium)[0] for one in (by_depth, by_force)]
        wanted = layered_load(at, depth, known, medium)
        for one in felt:
            assert np.abs(one - wanted).max() < bound * np.abs(wanted).max()


def test_surfaces_are_parabolas_cones_and_walls_without_ridges() -> None:
    x, y = cells(9, 1.0, 0.3)
    fine = [one.reshape(9, 5, 9, 5)[4:5, :, 4:5].reshape(5, 5) for one in (refined(a, 5) for a in (x, y))]
    for a, b, c in ((1.0, 2.0, 0.5), (-1.0, 0.3, 2.0)):
        bent = refined(a * x**2 + b * y**2 + c * x * y + x, 5)
        wanted = refined(x, 5) * (1 + a * refined(x, 5) + c * refined(y, 5)) + b * refined(y, 5) ** 2
        inner = slice(10, -10)  # at a border beside which it turns a parabola is held level
        assert bent[inner, inner] == pytest.approx(wanted[inner, inner], abs=1e-12)
    assert fine[0][0] == pytest.approx(0.3 + np.linspace(-0.4, 0.4, 5))
    # a flat end with a slanting edge, and a flat end with a wall: no ridge below them, the wall half-way
    slanting = refined(np.maximum(np.abs(x[:1]) - 2, 0.0), 8)
    assert slanting.min() == 0
    assert refined(np.tile([0.0, 1.0], 5)[None], 8).min() == 0  # nor at a border, of cells up and down
    flat = refined(np.where(np.hypot(x, y) < 2.6, 0.01 * x, 7.0), 4)
    assert sorted(np.unique(np.where(flat < 1, 0, flat)).tolist()) == [0.0, 7.0]
    assert (flat < 1).sum() == 16 * (np.hypot(x, y) < 2.6).sum()


def test_cells_that_do_not_tell_the_contact_are_told_of() -> None:
    def lines(heights: NDArray[np.float64], pitch: float, push: float) -> list[str]:
        body = HeightMap(0, heights, pitch, np.array([(0.0, 0, 0, 0, 0, push)]))
        array = TaxelArray("pad", 2, 2, 1e-3, 1e-3)
        return list(out_of_range(Scene("s", 10.0, 0.1, 2.4e6, (array,), (), (body,), (FiniteThickness(2e-3),))))

    x, y = cells(17, 5e-4, 0.3)
    assert lines(paraboloid(x, y), 5e-4, 0.3) == []
    (line,) = lines(np.hypot(x, y) / 5, 5e-4, 0.05)  # a cone, whose tip lies between the cells
    assert "mm wide on cells of 0.5 mm, which leave its force open by about" in line
    assert "at most 2% wanted, by smaller cells" in line
    (line,) = lines(np.where(np.hypot(x, y) < 1.6e-3, 0.0, 3e-3), 5e-4, 0.3)  # a flat end, whose wall does
    assert "on cells of 0.5 mm, which leave its force open by" in line
    x, y = cells(61, 7e-5, 0.3)
    assert lines(np.where(np.hypot(x, y) < 1.6e-3, 0.0, 3e-3), 7e-5, 0.3) == []
    line = lines(paraboloid(*cells(33, 2.5e-4, 0.0)), 2.5e-4, 20.0)[0]
    assert "mm deep in a cover of 2 mm; at most 0.3 of it wanted" in line


def test_a_height_map_pressed_in_deeper_than_its_contact_is_wide_is_told_of() -> None:
    """As a ball is that goes in by more than its radius, where a = R, and a flat end by more than its own."""

    def told(heights: NDArray[np.float64], pitch: float, deep: float) -> str:
        body = HeightMap(0, heights, pitch, np.array([(0.0, 0, 0, 0, 0, deep)]), None, True)
        array = TaxelArray("pad", 2, 2, 5e-3, 5e-3)
        return "\n".join(out_of_range(Scene("s", 10.0, 0.1, 2.4e5, (array,), (), (body,))))

    pitch, radius = 6e-5, 1e-3
    steps = (np.arange(51) - 25) * pitch
    square = steps**2 + steps[:, None] ** 2
    assert told(square / 2 / radius, pitch, 0.9 * radius) == ""
    assert "1.1 mm deep, 1.0" in told(square / 2 / radius, pitch, 1.1 * radius)
    end = np.where(square < radius**2, 0.0, 1.0)
    assert told(end, pitch, 0.5 * radius) == ""
    assert "30 mm deep" in told(end, pitch, 30 * radius)


def test_forces_of_nothing_and_maps_of_a_cell_or_two_are_pressed() -> None:
    for heights in (np.zeros((1, 1)), np.arange(9.0)[None] * 1e-5, np.add.outer(np.arange(6), np.arange(6)) * 1e-5):
        for push in (-1.0, 0.0, 1e-9, 0.1):
            body = HeightMap(0, heights, 4e-4, np.array([(0.0, 0, 0, 0, 0, push)]))
            loads = body.loads(np.zeros(1), 1e-3, Medium(2.4e6, thickness=1.2e-3))
            assert loads.totals[0, 0, 4] == pytest.approx(max(push, 0.0), abs=1e-15)
            assert loads.patterns[0].points()[..., 4].sum() == pytest.approx(max(push, 0.0), abs=1e-15)


def test_a_height_map_moves_slips_lifts_and_is_held() -> None:
    medium, times = Medium(2.4e6), np.linspace(0, 2, 5)
    path = np.array([(0.0, 0, 0, 0.5, 0, 0.5), (1.0, 1e-3, 0, 0, 0, -0.5), (2.0, 1e-3, 0, 0, 0, 0.5)])
    body = HeightMap(0, BALL, PITCH, path, 0.3)
    totals = body.loads(times, 1e-3, medium).totals[:, 0]
    assert totals[:, 4] == pytest.approx((0.5, 0, 0, 0, 0.5), abs=1e-12)
    assert totals[0, 2] == pytest.approx(0.15)
    assert totals[:, 0] == pytest.approx((0, 5e-4, 1e-3, 1e-3, 1e-3))
    raised = Rig().with_move(lambda places: (np.zeros_like(places), np.full(len(places), 1e-6)), 50e-6)
    grown = body.loads(times, 1e-3, medium, raised).totals[0, 0, 4] / 0.5
    ball = Indenter("sphere", R).held_factor(np.array([0.5]), np.array([1e-6]), medium, 0.0)[0]
    assert grown - 1 == pytest.approx(ball - 1, rel=0.05)
    deep = HeightMap(0, BALL, PITCH, np.array([(0.0, 0, 0, 0, 0, 1e-4)]), None, True)
    force = Indenter("sphere", R).force_at(np.array([1e-4]), medium)[0]
    assert deep.loads(np.zeros(1), 1e-3, medium).totals[0, 0, 4] == pytest.approx(force, rel=0.02)
    with pytest.raises(InputError, match="at most half the depth wanted"):
        body.loads(times, 1e-4, medium)
    through = HeightMap(0, BALL, PITCH, np.array([(0.0, 0, 0, 0, 0, 3e-3)]), None, True)
    with pytest.raises(InputError, match=r"into a cover of 1\.2 mm; less than its thickness wanted"):
        through.loads(np.zeros(1), 1e-3, Medium(2.4e6, thickness=1.2e-3))
