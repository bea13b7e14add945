"""Precision of located loads under noise, and of their standard deviations."""

from functools import partial

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import SCALE, array, as_row, found, locate, measured, random_load
from tests.oracles.elastic.localise import bound, nearest


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("shape", [(2, 2), (3, 3), (8, 8)])
def test_the_answer_is_that_of_least_squares(shape: tuple[int, int], stress: bool) -> None:
    random, at = np.random.default_rng(5), array(*shape)
    for _ in range(20):
        wanted = random_load(random, *shape) * [1, 1, 0.2, 0.2, 0] + [0, 0, 0, 0, 1]
        signals = measured(at, [wanted], stress)
        signals = signals + random.normal(size=signals.shape) * np.abs(signals).max() * 0.01
        load, best = (
            found(at, signals, stress),
            nearest(lambda p: measured(at, p, stress), signals, wanted[None], SCALE)[0],
        )
        assert np.abs((np.array(as_row(load)) - best) / SCALE).max() < 2e-3


def test_taxels_on_a_line_use_all_of_them() -> None:
    """Errors near the bound of an estimate of x, y, Q and F."""
    random, wanted, at = np.random.default_rng(3), np.array([4.2e-3, -2.3e-3, 0.1, 0.0, 0.4]), array(1, 9)
    strain = measured(at, [wanted], False)
    noise, errors = 0.01 * float(np.abs(strain).max()), []
    for _ in range(200):
        load = locate(at, strain + random.normal(size=strain.shape) * noise)
        errors.append(np.array(as_row(load))[[0, 1, 2, 4]] - wanted[[0, 1, 2, 4]])
    least = bound(lambda p: measured(at, p, False), wanted, noise, SCALE, (0, 1, 2, 4))
    assert (np.sqrt(np.mean(np.square(errors), axis=0)) < 1.2 * least).all()


@pytest.mark.parametrize("given_noise", [False, True])
@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("side", "level"), [(2, 3e-2), (4, 1e-3), (32, 1e-2)])
def test_errors_and_deviations_are_near_the_cramer_rao_bound(
    side: int, level: float, stress: bool, given_noise: bool
) -> None:
    random, at = np.random.default_rng(side), array(side, side)
    ratio, own = [], []
    for _ in range(60 if side < 32 else 25):
        wanted = random_load(random, side, side) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = measured(at, [wanted], stress)
        noise = level * float(np.abs(signals).max())
        noisy = signals + random.normal(size=signals.shape) * noise
        load = found(at, noisy, stress, noise if given_noise else None)
        error = (np.array(as_row(load)) - wanted)[:2]
        ratio.append(error / bound(lambda p: measured(at, p, stress), wanted, noise, SCALE)[:2])
        own.append(error / load.sigma[:2])
    assert np.sqrt(np.mean(np.square(ratio))) < 1.3
    assert np.mean(np.abs(own) < 2) > 0.85
    assert np.mean(np.abs(own) < 0.5) < 0.6


def _over(at: Floats, noise: Floats, loads: Floats) -> Floats:
    return measured(at, loads, False) / noise


def test_taxels_are_weighted_by_their_noise() -> None:
    """Half of the taxels with ten times the noise, and normals with three times that of shear: near the bound."""
    random, at = np.random.default_rng(4), array(4, 4)
    sigma = np.where(random.random((4, 4, 1)) < 0.5, 10.0, 1.0) * [1.0, 1.0, 3.0]
    weighed, alike, wider = [], [], 0
    for _ in range(80):
        wanted = random_load(random, 4, 4) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = measured(at, [wanted], False)
        own = sigma * 1e-3 * float(np.abs(signals).max())
        noisy = signals + random.normal(size=signals.shape) * own
        least = bound(partial(_over, at, own), wanted, 1.0, SCALE)[:2]
        load = found(at, noisy, False, own)
        weighed.append((np.array(as_row(load)) - wanted)[:2] / least)
        assert load.scatter[:2] == pytest.approx(tuple(least), rel=0.6)
        wider += load.sigma != load.scatter
        alike.append((np.array(as_row(found(at, noisy, False))) - wanted)[:2] / least)
    assert wider <= 4
    assert np.sqrt(np.mean(np.square(weighed))) < 1.3
    assert np.sqrt(np.mean(np.square(alike))) > 2


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("shape", "free"), [((1, 2), 2), ((1, 3), 5), ((2, 2), 7)])
def test_sigma_with_few_degrees_of_freedom(shape: tuple[int, int], free: int, stress: bool) -> None:
    """68 % lie within sigma, a quantile of Student's distribution."""
    random, at, own = np.random.default_rng(9), array(*shape), []
    known = [0, 1, 2, 4] if shape[0] == 1 else [0, 1, 2, 3, 4]
    for _ in range(400):
        wanted = random_load(random, *shape) * [0.5, 1, 0.1, 0.1 * (shape[0] > 1), 0] + [2e-3, 0, 0, 0, 1]
        signals = measured(at, [wanted], stress)
        noisy = signals + random.normal(size=signals.shape) * 1e-3 * float(np.abs(signals).max())
        load = found(at, noisy, stress)
        if load.validity is Validity.INSIDE:
            own.append(((np.array(as_row(load)) - wanted) / load.sigma)[known])
    assert len(own) > 200
    within = np.mean(np.abs(own) < 1)
    assert within == pytest.approx(0.683, abs=0.05), free


def test_noise_that_is_not_positive_is_refused() -> None:
    at = array(2, 2)
    strain = measured(at, [(4e-3, -2e-3, 0, 0, 1)], False)
    for wrong in (0.0, np.zeros((2, 2, 3)), np.ones((2, 3, 3))):
        with pytest.raises(InputError, match="positive numbers, one or"):
            locate(at, strain, wrong)
