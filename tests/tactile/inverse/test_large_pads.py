"""Many loads on a large pad: all are found, with their places and forces."""

import numpy as np
import pytest

from cnnsim.support import Floats
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, PITCH, array, found, measured

SIDE = 32


def scattered(count: int, apart: float, random: np.random.Generator) -> Floats:
    """Return pressing loads on a pad of `SIDE` taxels a side, at least ``apart`` depths from each other."""
    places: list[Floats] = []
    while len(places) < count:
        place = np.array([4e-3, -2e-3]) + random.uniform(-0.45, 0.45, 2) * SIDE * PITCH
        if all(np.hypot(*(place - other)) > apart * DEPTH for other in places):
            places.append(place)
    shear = random.uniform(-0.05, 0.05, (count, 2))
    return np.column_stack([places, shear, random.uniform(0.3, 0.6, count)])


def noisy(loads: Floats, part: float, random: np.random.Generator, stress: bool = False) -> Floats:
    signals = measured(array(SIDE, SIDE), loads, stress)
    return signals + part * np.abs(signals).max() * random.normal(size=signals.shape)


def every(load: Load) -> list[Load]:
    return [load, *load.others]


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("count", "apart"), [(3, 8.0), (7, 4.0), (16, 4.0)])
def test_many_loads_are_located(count: int, apart: float, stress: bool) -> None:
    random, wrong, covered, right = np.random.default_rng(count), 0, 0, 0
    for _ in range(4):
        loads = scattered(count, apart, random)
        answers = every(found(array(SIDE, SIDE), noisy(loads, 0.005, random, stress), stress))
        assert len(answers) == count
        for x, y, *_, f in loads:
            near = min(answers, key=lambda one: float(np.hypot(one.x - x, one.y - y)))
            error = np.hypot(near.x - x, near.y - y)
            right += error < 0.1 * DEPTH and abs(near.F - f) < 0.05
            wrong += bool(error > 0.5 * DEPTH and near.validity in (Validity.INSIDE, Validity.OUTSIDE))
            covered += error < 4 * np.hypot(near.sigma[0], near.sigma[1])
    assert right >= 0.96 * 4 * count
    assert not wrong  # wrong ones are not INSIDE
    assert covered >= 0.9 * 4 * count


def test_a_patch_and_a_point_are_distinguished() -> None:
    random, edge = np.random.default_rng(0), np.linspace(-2.5, 2.5, 12) * DEPTH
    patch = np.array([[14e-3 + x, 9e-3 + y, 0, 0, 0.01] for x in edge for y in edge])
    point = np.array([[-12e-3, -14e-3, 0.05, 0, 0.3]])
    load = found(array(SIDE, SIDE), noisy(np.concatenate([patch, point]), 0.002, random), False)
    one = min(every(load), key=lambda one: float(np.hypot(one.x + 12e-3, one.y + 14e-3)))
    assert np.hypot(one.x + 12e-3, one.y + 14e-3) < 0.05 * DEPTH
    assert one.validity == Validity.INSIDE
    rest = [other for other in every(load) if other is not one]
    assert rest
    assert all(other.validity in (Validity.NOT_ONE, Validity.AMBIGUOUS) for other in rest)


def test_a_false_taxel_is_not_a_load() -> None:
    random = np.random.default_rng(1)
    loads = scattered(3, 10.0, random)
    signals = noisy(loads, 0.002, random)
    at = array(SIDE, SIDE)
    away = np.hypot(*(at[None] - loads[:, None, None, :2]).transpose(3, 0, 1, 2)).min(axis=0)
    row, col = divmod(int(away.argmax()), SIDE)
    signals[row, col, 2] = np.abs(signals).max()
    load = found(at, signals, False)
    assert len(every(load)) == 3
    assert load.left_out == ((row, col),)
    assert all(one.validity == Validity.INSIDE for one in every(load))


def test_a_saturated_taxel_has_its_place_on_the_pad() -> None:
    random = np.random.default_rng(2)
    loads = scattered(2, 12.0, random)
    signals = noisy(loads, 0.001, random)
    at = array(SIDE, SIDE)
    near = np.hypot(*(at - loads[0, :2]).transpose(2, 0, 1))
    row, col = divmod(int(near.argmin()), SIDE)
    ends = np.zeros((SIDE, SIDE), bool)
    ends[row, col] = True
    load = found(at, signals, False, saturated=ends)
    assert load.saturated == ((row, col),)
    assert len(every(load)) == 2


@pytest.mark.parametrize("part", [0.0, 0.01])
def test_a_weak_second_load_far_away_is_found_and_no_false_one(part: float) -> None:
    random = np.random.default_rng(1)
    (one,) = scattered(1, 8.0, random)
    assert found(array(SIDE, SIDE), noisy(one[None], part, random), False).others == ()
    weak = np.array([[one[0] - np.sign(one[0]) * 8 * DEPTH, one[1] - np.sign(one[1]) * 8 * DEPTH, 0, 0, 0.15 * one[4]]])
    load = found(array(SIDE, SIDE), noisy(np.concatenate([one[None], weak]), part, random), False)
    assert len(every(load)) == 2
