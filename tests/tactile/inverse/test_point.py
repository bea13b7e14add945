"""One point at one go: to the last bit what the inverse in every cell and the long way say, in doubt or not."""

import numpy as np
import pytest

from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.inverse.weights import weigh
from tactile.settings import Settings

MODULUS = 2.4e6


def finger(array: TaxelArray, *, at_one_go: bool) -> Finger:
    """Return a finger that locates at one go, or by the machine's program and `localise` alone."""
    made = Finger(array, MODULUS, Settings(tare="off"))
    assert made._point is not None
    if not at_one_go:
        made._point = None
    return made


def reading(array: TaxelArray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return what an array reads of one load or two, with noise, false, silent and idle taxels, and the noise."""
    wide = np.array([array.cols, array.rows]) * array.pitch / 1.6
    loads = [
        [*rng.uniform(-wide, wide), *rng.normal(0, 0.3, 2), rng.uniform(0.05, 2)] for _ in range(rng.integers(1, 3))
    ]
    loads = loads if rng.random() < 0.2 else loads[:1]
    at, depth = array.positions(), array.depth
    strain = array.quantity == "strain"
    values = point_load_strain(at, depth, loads, MODULUS) if strain else point_load_stress(at, depth, loads)
    noise = float(np.abs(values).max() * 10 ** rng.uniform(-6, -1) * (rng.random() < 0.8))
    values = values + noise * rng.normal(size=values.shape)
    where, of = rng.integers(array.rows), rng.integers(array.cols)
    chance = rng.random()
    if chance < 0.1:
        values[where, of] *= 3
    elif chance < 0.15:
        values[where, of] = np.nan
    elif chance < 0.2:
        values *= 1e-9
    return values, noise


def at_length(one: Finger, frame: Frame) -> Load:
    """Return what the long way alone says."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tactile.inverse.localise.of_answers", lambda *_: None)
        return one.locate(frame)


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_the_same_to_the_last_bit(quantity: Quantity) -> None:
    rng, simple, tried = np.random.default_rng(5), 0, 0
    for _ in range(7):
        pitch, depth = (1e-3 * rng.uniform(0.5, 2, 2)).tolist()
        rows, cols = (int(side) for side in rng.integers(2, 11, 2))
        array = TaxelArray("pad", rows, cols, pitch, depth, quantity=quantity)
        fast, long = finger(array, at_one_go=True), finger(array, at_one_go=False)
        for n in range(12):
            values, noise = reading(array, rng)
            if noise and n % 3:
                each = rng.uniform(0.5, 1.5, (rows, cols, 3)) if n % 3 == 1 else 1.0
                fast._weights = long._weights = weigh(noise * fast._newtons * each, array.shape)
            frame = Frame(0, 0.0, n, values, np.ones(array.shape, bool))
            wanted = repr(vars(at_length(long, frame)))
            assert repr(vars(fast.locate(frame))) == wanted
            assert repr(vars(long.locate(frame))) == wanted
            if n % 4 == 0:
                long._saturated = rng.random(array.shape) < 0.1
                assert repr(vars(long.locate(frame))) == repr(vars(at_length(long, frame)))
                long._saturated = None
            assert fast._point is not None
            tried, simple = tried + 1, simple + (fast._point(values, fast._weights) is not None)
    assert 0.4 * tried < simple < 0.9 * tried  # both ways were gone


def test_nothing_is_told_from_unknown() -> None:
    array = TaxelArray("pad", 3, 3, 1e-3, 1e-3, quantity="strain")
    one, values = finger(array, at_one_go=True), np.zeros((3, 3, 3))
    assert one._point is not None
    nothing = one._point(values, one._weights)
    assert nothing is not None
    assert nothing.validity is Validity.NO_LOAD
    values[1, 1, 2] = np.nan
    assert one._point(values, one._weights) is None
    assert one.locate(Frame(0, 0.0, 0, values, np.ones((3, 3), bool))).validity is Validity.INVALID


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_more_taxels_than_a_block(quantity: Quantity) -> None:
    """The compiled inverse goes by blocks of 256 taxels: a load beside the last taxels of an array is told as well."""
    array = TaxelArray("pad", 20, 20, 1e-3, 1e-3, quantity=quantity)
    at, loads = array.positions(), [[*array.positions()[18, 17], 0.0, 0.0, 0.5]]
    strain = quantity == "strain"
    values = point_load_strain(at, array.depth, loads, MODULUS) if strain else point_load_stress(at, array.depth, loads)
    one = finger(array, at_one_go=True)
    assert one._point is not None
    found = one._point(values, one._weights)
    assert found is not None
    assert found.validity is Validity.INSIDE
