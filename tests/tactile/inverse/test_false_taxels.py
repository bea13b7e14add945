"""Located loads with dead, stuck, clipped and otherwise false taxels."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import Frame, TaxelArray
from tactile.elastic.halfspace import point_load_strain
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.inverse.localise import localise
from tactile.inverse.validity import Validity
from tactile.settings import Settings
from tests.kits.touch.pads import DEPTH, MODULUS, PITCH, array, as_row, found, locate, measured, random_load


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


def test_random_strains_are_ambiguous() -> None:
    """Four taxels with unrelated strains: no load explains them."""
    at = array(2, 2)
    random = np.random.default_rng(11)
    codes = [locate(at, random.normal(size=(2, 2, 3)) * 1e-3).validity for _ in range(50)]
    assert codes.count(Validity.AMBIGUOUS) + codes.count(Validity.NOT_ONE) >= 48


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("side", [2, 4, 16])
def test_a_stuck_taxel_is_named_and_does_not_change_the_load(side: int, stress: bool) -> None:
    random, at = np.random.default_rng(side), array(side, side)
    gross = named = 0
    for n in range(100):
        wanted = random_load(random, side, side) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = measured(at, [wanted], stress)
        peak = np.abs(signals).max()
        signals = signals + random.normal(size=signals.shape) * 0.01 * peak
        row, col = random.integers(0, side, 2).tolist()
        signals[row, col] = random.normal(size=3) * peak * (1, 3)[n % 2]
        load = found(at, signals, stress)
        gross += bool(np.hypot(*(np.array(as_row(load)) - wanted)[:2]) > 0.3 * DEPTH)
        named += load.left_out == ((row, col),)
    assert gross <= 2
    assert named >= 94


@pytest.mark.parametrize("stress", [False, True])
def test_saturated_taxels_are_marked_and_left_out(stress: bool) -> None:
    random, at = np.random.default_rng(6), array(8, 8)
    for _ in range(20):
        wanted = random_load(random, 6, 6) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = measured(at, [wanted], stress)
        end = 0.6 * np.abs(signals).max()
        saturated = (np.abs(signals) > end).any(axis=-1)
        load = found(at, np.clip(signals, -end, end), stress, saturated=saturated)
        assert as_row(load) == pytest.approx(tuple(wanted), rel=1e-6, abs=1e-7)
        assert load.saturated == tuple(map(tuple, np.argwhere(saturated).tolist()))
        assert load.left_out == ()
        assert load.taxels == 64 - saturated.sum()
    assert found(at, signals, stress, saturated=np.ones((8, 8), bool)).validity == Validity.INVALID


def test_a_finger_measures_its_noise_and_the_ends_of_its_range() -> None:
    """An amplifier that clips at a third of the peak: a right place with a right sigma."""
    random = np.random.default_rng(2)
    pad = TaxelArray("pad", 6, 6, PITCH, DEPTH)
    peak = float(np.abs(point_load_strain(pad.positions(), DEPTH, [(0.2e-3, 0.1e-3, 0, 0, 1)], MODULUS)).max())
    finger, errors, last = Finger(pad, MODULUS, Settings()), [], Load()
    for n in range(300):
        strain = point_load_strain(
            pad.positions(), DEPTH, [(0.2e-3, 0.1e-3, 0, 0, min(max(n - 100, 0) / 50, 1))], MODULUS
        )
        strain = strain + random.normal(size=strain.shape) * 1e-3 * peak
        frame = Frame(0, n / 100, n, np.clip(strain, -peak / 3, peak / 3), np.ones((6, 6), bool))
        last = finger.locate(finger.calibrate(frame))
        if n >= 200:
            errors.append((last.x - 0.2e-3) / last.sigma[0])
    assert 1 <= len(last.saturated) <= 8
    assert np.abs(last.x - 0.2e-3) < 0.02 * DEPTH
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 2


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("side", "pitch"), [(3, 1), (8, 2)])
def test_an_undeclared_clipped_reading_is_recognised(side: int, pitch: int, stress: bool) -> None:
    """The amplifier clips at 0.6 of the peak: residuals there point outwards, and vanish without these readings."""
    random, at = np.random.default_rng(side), TaxelArray("pad", side, side, pitch * PITCH, DEPTH).positions()
    off, named = [], 0
    for _ in range(20):
        x, y = random.uniform(-0.4, 0.4, 2) * side * pitch * PITCH
        signals = measured(at, [(x, y, 0.05, -0.03, 1.0)], stress)
        end = 0.6 * np.abs(signals).max()
        false = (np.abs(signals) > end).any(axis=-1)
        load = found(at, np.clip(signals + random.normal(size=signals.shape) * 1e-4 * end, -end, end), stress)
        if load.validity is Validity.INSIDE:
            off.append(np.hypot(load.x - x, load.y - y) / DEPTH)
            named += set(load.saturated) == set(map(tuple, np.argwhere(false).tolist()))
    assert len(off) >= 8 * (1 + (pitch == 1))
    assert max(off) < 0.3
    assert np.median(off) < 0.01
    assert named >= len(off) - 2


def test_a_false_taxel_or_a_second_load_is_ambiguous() -> None:
    """At a pitch of four depths one taxel measures the second load: the first one's place is right, the number not."""
    random, at = np.random.default_rng(1), TaxelArray("pad", 5, 5, 4 * DEPTH, DEPTH).positions()
    first, second = (0.3 * DEPTH, 0.2 * DEPTH, 0.0, 0.0, 0.4), (8.2 * DEPTH, 7.9 * DEPTH, 0.0, 0.0, 0.2)
    signals = measured(at, [first, second], True)
    load = found(at, signals + random.normal(size=signals.shape) * 5e-3 * np.abs(signals).max(), True)
    assert load.x == pytest.approx(first[0], abs=0.05 * DEPTH)
    assert len(load.others) == 1 or load.validity in (Validity.AMBIGUOUS, Validity.NOT_ONE)


def test_a_load_measured_by_one_taxel_of_a_pad_is_ambiguous() -> None:
    """Residual strain of viscous rubber: one taxel reads a small pull, like newtons many depths away."""
    pad = TaxelArray("pad", 4, 4, 1e-3, 1e-3)
    finger = Finger(pad, 2.4e6, Settings())
    values = np.zeros((4, 4, 3))
    values[2, 2] = 5e-4, 9e-4, 2.2e-3
    load = finger.locate(Frame(0, 0.0, 0, values, np.ones((4, 4), bool)))
    assert load.taxels == 1
    assert load.validity is Validity.AMBIGUOUS
    alone = Finger(TaxelArray("one", 1, 1, 1e-3, 1e-3), 2.4e6, Settings())
    known = alone.locate(Frame(0, 0.0, 0, values[2:3, 2:3], np.ones((1, 1), bool)))
    assert known.validity is Validity.OUTSIDE
