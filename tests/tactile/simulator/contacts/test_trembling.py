"""Contacts that several things raise and lower: each presses by its own law at the sum of them, as deep as that is."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.core.loads import COLUMNS
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.summation import field_at

R, TIP, DEPTH = 5e-3, 5e-5, 1e-3
RUBBER, LAYER = Medium(2.4e6), Medium(2.4e6, 0.45, thickness=3e-3)
SIDE = 81
STEPS = (np.arange(SIDE) - SIDE // 2) * 5e-5
BALL = (STEPS[None] ** 2 + STEPS[:, None] ** 2) / 2 / R


def rig(*rises: Any, shift: float = 0.0, work: float = 0.0) -> Rig:
    """Moves one after the other, each a number for all frames or one for every frame."""
    held = Rig(work=work)
    for rise in rises:

        def move(places: NDArray[np.float64], rise: Any = rise) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
            return np.full_like(places, shift), np.broadcast_to(rise, len(places))

        held = held.with_move(move, TIP)
    return held


def pressed(shape: str, force: float, by_depth: bool = False) -> Any:
    path = np.array([(0.0, 0, 0, 0.1 * force, 0, force)])
    if shape == "load":
        return MovingLoad(0, path)
    if shape == "height_map":
        return HeightMap(0, BALL, 5e-5, path, None, by_depth)
    sizes = {"sphere": R, "needle": 2e-3, "flat_punch": 1e-4, "disc": 1e-4, "cylinder": 2e-3}
    return MovingContact(0, Indenter(shape, sizes.get(shape, 0.0), 8e-3), path, None, by_depth)


def total(contact: Any, medium: Medium, held: Rig, frames: int = 1) -> NDArray[np.float64]:
    found = contact.loads(np.zeros(frames), DEPTH, medium, held).totals
    assert found.shape == (frames, 1, COLUMNS)
    return np.asarray(found[:, 0])


@pytest.mark.parametrize("medium", (RUBBER, LAYER), ids=("half-space", "layer"))
@pytest.mark.parametrize(
    "shape", ("load", "point", "sphere", "needle", "flat_punch", "disc", "cylinder", "edge", "height_map")
)
def test_what_one_effect_lifts_off_another_presses_on(shape: str, medium: Medium) -> None:
    contact = pressed(shape, 2e-3)
    for first, then in ((-3e-5, 3.2e-5), (3.2e-5, -3e-5)):
        both, sum_ = total(contact, medium, rig(first, then))[0], total(contact, medium, rig(first + then))[0]
        assert both == pytest.approx(sum_, rel=1e-9)
        assert both[4] > 2e-3
        assert both[2] == pytest.approx(0.1 * both[4])
    assert total(contact, medium, rig(-3e-5, 2e-5 if shape != "edge" else 0.0))[0, 4] < 2e-3


@pytest.mark.parametrize("by_depth", (False, True))
def test_what_sticks_is_raised_by_the_sum_too(by_depth: bool) -> None:
    contact = pressed("sphere", 1e-6 if by_depth else 2e-3, by_depth)
    down = -5e-5  # far beyond where it snaps off
    both = total(contact, RUBBER, rig(down, 1e-6 - down, work=0.05))[0]
    assert both == pytest.approx(total(contact, RUBBER, rig(1e-6, work=0.05))[0], rel=1e-9)


def test_places_move_before_the_next_effect_looks_at_them() -> None:
    seen = []

    def look(places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        seen.append(places.copy())
        return np.zeros_like(places), np.zeros(len(places))

    for shape, work in (("sphere", 0.0), ("sphere", 0.05), ("height_map", 0.0), ("point", 0.0)):
        seen.clear()
        rows = total(pressed(shape, 2e-3), RUBBER, rig(0.0, shift=1e-4, work=work).with_move(look, TIP))
        assert [place.tolist() for place in seen] == [[[1e-4, 1e-4]]]
        assert rows[0, :2].tolist() == [1e-4, 1e-4]


@pytest.mark.parametrize("medium", (RUBBER, LAYER), ids=("half-space", "layer"))
@pytest.mark.parametrize("by_depth", (False, True))
def test_a_height_map_that_is_raised_presses_as_deep_as_that_is(medium: Medium, by_depth: bool) -> None:
    """Far beyond what its path asks for: the ball's own law, and its field."""
    ball, rises = Indenter("sphere", R), np.array([0.0, -2e-6, 1e-6, 3e-6, 1e-5, 3e-5])
    push = 4e-6 if by_depth else float(ball.force_at(np.array([4e-6]), medium)[0])
    wanted = ball.force_at(4e-6 + rises, medium)
    held, one = pressed("height_map", push, by_depth), pressed("sphere", push, by_depth)
    found = held.loads(np.zeros(6), DEPTH, medium, rig(rises))
    assert found.totals[:, 0, 4] == pytest.approx(wanted, rel=0.02)
    assert sum(one.rows[:, 4] for one in found.patterns) == pytest.approx(found.totals[:, 0, 4])
    at = np.array([[0.0, 0.0], [7e-4, 2e-4], [1.5e-3, 0.0]])
    felt, known = (
        field_at(at, DEPTH, loads, medium) for loads in (found, one.loads(np.zeros(6), DEPTH, medium, rig(rises)))
    )
    for mine, others in zip(felt, known, strict=True):
        assert np.abs(mine - others).max() < 0.02 * np.abs(others).max()
    # the same however the frames are cut
    for k in range(6):
        alone = total(held, medium, rig(float(rises[k])))
        assert alone[0] == pytest.approx(found.totals[k, 0], rel=1e-12)


def test_a_height_map_raised_through_its_layer_is_refused() -> None:
    with pytest.raises(InputError, match=r"into a cover of 3 mm; less than its thickness wanted"):
        total(pressed("height_map", 2e-3), LAYER, rig(np.array([0.0, 3.1e-3])), 2)
