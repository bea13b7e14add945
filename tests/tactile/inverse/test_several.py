"""Several loads at once, and wide patches."""

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, PITCH, array, found, measured, random_load


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("count", [2, 3])
def test_loads_well_apart_are_separated(count: int, stress: bool) -> None:
    random, at, right = np.random.default_rng(count), array(8, 8), 0
    for _ in range(40):
        gap = 0.0
        while gap < 2.2 * DEPTH:
            loads = np.array([random_load(random, 8, 8) * [1, 1, 0.05, 0.05, 0] for _ in range(count)])
            gap = min(np.hypot(*(a - b)[:2]) for k, a in enumerate(loads) for b in loads[:k])
        loads[:, 4] = random.uniform(0.15, 0.4, count)
        signals = measured(at, loads, stress)
        load = found(at, signals + random.normal(size=signals.shape) * 0.005 * np.abs(signals).max(), stress)
        places = np.array([(one.x, one.y) for one in (load, *load.others)])
        near = [np.hypot(*(places - one[:2]).T).min() < 0.2 * DEPTH for one in loads]
        right += len(places) == count and all(near)
        assert len(places) == count or load.validity in (Validity.NOT_ONE, Validity.AMBIGUOUS)
    assert right >= 38


def test_two_loads_are_not_one_between_them() -> None:
    at = TaxelArray("pad", 8, 8, PITCH, DEPTH).positions()
    load = found(at, measured(at, [(-2e-3, 0, 0, 0, 0.3), (2e-3, 0, 0, 0, 0.3)], True), True)
    assert sorted(one.x for one in (load, *load.others)) == pytest.approx([-2e-3, 2e-3])
    assert [one.F for one in (load, *load.others)] == pytest.approx([0.3, 0.3])


@pytest.mark.parametrize("stress", [False, True])
def test_a_wide_patch_is_not_a_point_load(stress: bool) -> None:
    at = array(8, 8)
    edge = np.linspace(-2.5, 2.5, 12) * DEPTH
    patch = np.array([[4e-3 + x, -2e-3 + y, 0, 0, 0.01] for x in edge for y in edge])
    load = found(at, measured(at, patch, stress), stress)
    assert load.validity == Validity.NOT_ONE
    assert load.misfit > 0.25
