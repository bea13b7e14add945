"""Located loads where taxels read nothing, the same for ever, or something that no load makes."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse.load import Load
from tactile.inverse.localise import localise
from tactile.inverse.validity import Validity
from tests.kits.pads import DEPTH, MODULUS, array, as_row, felt, found, locate, random_load


def test_broken_and_unloaded_taxels() -> None:
    at = array(2, 2)
    assert locate(at, np.zeros((2, 2, 3))) == Load()
    assert Load().validity == Validity.NO_LOAD
    broken = np.zeros((2, 2, 3))
    broken[0, 1, 2] = np.nan
    assert locate(at, broken).validity == Validity.INVALID
    wanted = (4.2e-3, -2.3e-3, 0.0, 0.0, 0.4)
    strain = point_load_strain(at, DEPTH, [wanted], MODULUS)
    strain[0] = np.inf
    alone = locate(at, strain)
    assert alone.taxels == 2
    assert (alone.x, alone.y) == pytest.approx(wanted[:2])
    none = np.zeros((2, 2))
    with pytest.raises(InputError, match=r"\(2, 2\) for an array of \(3, 3\)"):
        localise(array(3, 3), (none, none, none, none), None, DEPTH)


def test_a_place_that_does_not_stand_out_is_called_ambiguous() -> None:
    """Four taxels with unrelated strains: no load explains them, and the answer must not look sure."""
    at = array(2, 2)
    random = np.random.default_rng(11)
    codes = [locate(at, random.normal(size=(2, 2, 3)) * 1e-3).validity for _ in range(50)]
    assert codes.count(Validity.AMBIGUOUS) + codes.count(Validity.NOT_ONE) >= 48


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("side", [2, 3, 4, 8, 16])
def test_a_stuck_taxel_is_named_and_spoils_nothing(side: int, stress: bool) -> None:
    random, at = np.random.default_rng(side), array(side, side)
    gross = named = 0
    for n in range(100):
        wanted = random_load(random, side, side) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = felt(at, [wanted], stress)
        peak = np.abs(signals).max()
        signals = signals + random.normal(size=signals.shape) * 0.01 * peak
        row, col = random.integers(0, side, 2).tolist()
        signals[row, col] = random.normal(size=3) * peak * (1, 3)[n % 2]
        load = found(at, signals, stress)
        gross += bool(np.hypot(*(np.array(as_row(load)) - wanted)[:2]) > 0.3 * DEPTH)
        named += load.left_out == ((row, col),)
    assert gross <= 2
    assert named >= 94
