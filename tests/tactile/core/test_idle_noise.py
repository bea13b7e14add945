"""Frames of noise have no load, and light loads above the noise are located."""

import numpy as np
import pytest

from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.core.noise import measured
from tactile.core.noise_numba import is_noise
from tactile.core.source import FrameStream
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.pipeline import run
from tactile.settings import Settings

MODULUS, IDLE = 1e6, 200


def located(array: TaxelArray, sigma: float, pressed: np.ndarray | float, valid: bool = True) -> list[Load]:
    """Return the loads of IDLE frames of noise and of IDLE frames with ``pressed`` added, which may be invalid."""
    random = np.random.default_rng(array.rows)
    values = sigma * random.normal(size=(2 * IDLE, *array.shape, 3))
    values[IDLE:] += pressed
    frames = [Frame(0, 0.01 * k, k, one, np.full(array.shape, valid or k < IDLE)) for k, one in enumerate(values)]
    found = list[Load]()
    run(FrameStream("idle", (array,), MODULUS, 2 * IDLE, frames), Settings(), [lambda step: found.append(step.load)])
    return found


@pytest.mark.parametrize("side", [2, 8, 16])
@pytest.mark.parametrize(("quantity", "sigma"), [("strain", 3e-4), ("stress", 1e-3 * MODULUS)])
def test_noise_is_no_load(quantity: Quantity, sigma: float, side: int) -> None:
    array = TaxelArray("pad", side, side, 1e-3, 1e-3, quantity=quantity)
    assert {load.validity for load in located(array, sigma, 0.0)[60:]} == {Validity.NO_LOAD}


def test_a_light_load_is_located() -> None:
    """8 sigma on one taxel, or 2 sigma on all 64."""
    array = TaxelArray("pad", 8, 8, 1e-3, 1e-3, quantity="stress")
    one = np.zeros((8, 8, 3))
    one[3, 4, 2] = -8e3
    for pressed in (one, np.full((8, 8, 3), [0.0, 0.0, -2e3])):
        found = located(array, 1e3, pressed)[IDLE + 5 : IDLE + 25]
        assert np.mean([load.validity is not Validity.NO_LOAD for load in found]) > 0.9


@pytest.mark.parametrize(("side", "pitch", "noise"), [(32, 1.0, 0.02), (16, 1.5, 0.06), (4, 1.5, 0.04)])
def test_a_light_load_among_many_quiet_taxels_is_one_point_load(side: int, pitch: float, noise: float) -> None:
    """Most taxels see noise near the dead band of 1e-3; the load is 30 times that."""
    array = TaxelArray("pad", side, side, pitch * 1e-3, 1e-3)
    place = array.positions()[side // 2, side // 2] + (2e-4, -3e-4)
    strain = point_load_strain(array.positions(), 1e-3, [(*place, 0.02, -0.03, 0.1)], MODULUS)
    found = located(array, noise * 0.03, strain * 0.03 / np.abs(strain).max())[IDLE:]
    assert np.mean([load.validity is Validity.NOT_ONE for load in found]) <= 0.02
    assert np.mean([load.validity is Validity.INSIDE for load in found]) >= 0.95
    off = [np.hypot(load.x - place[0], load.y - place[1]) / np.hypot(*load.sigma[:2]) for load in found]
    assert max(off) < 5


def test_the_noise_of_few_frames_is_not_low() -> None:
    random = np.random.default_rng(0)
    for frames in (20, 41, 100):
        typical = np.mean([measured(random.normal(size=(frames, 8, 8, 3))).typical for _ in range(30)])
        assert typical == pytest.approx(1.0, abs=0.015)


def test_frames_without_valid_taxels_are_invalid() -> None:
    array = TaxelArray("pad", 4, 4, 1e-3, 1e-3, quantity="stress")
    found = located(array, 1e3, 0.0, valid=False)
    assert {load.validity for load in found[60:IDLE]} == {Validity.NO_LOAD}
    assert {load.validity for load in found[IDLE:]} == {Validity.INVALID}


def test_missing_readings_are_no_noise() -> None:
    values = np.zeros((2, 2, 3))
    assert is_noise(values, np.ones(values.shape))
    values[0, 0, 0] = np.nan
    assert not is_noise(values, np.ones(values.shape))
