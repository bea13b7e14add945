"""Loads for which a false reading allows a second answer: the reading is named, or the load is ambiguous."""

import numpy as np
import pytest

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, as_row, found, measured
from tests.tactile.inverse.trials import KINDS, LINES, trial


def scene(
    random: np.random.Generator, shape: tuple[int, int], pitch: float, level: float, stress: bool
) -> tuple[Floats, Floats, Floats, float]:
    """Return the places of a pad's taxels, a load, their noisy readings, and the noise."""
    at = TaxelArray("pad", *shape, pitch * DEPTH, DEPTH).positions()
    half = np.array([shape[1], shape[0]]) * pitch * DEPTH / 2
    load = np.array([*random.uniform(-1, 1, 2) * half, *random.uniform(-0.1, 0.1, 2), 0.4])
    signals = measured(at, [load], stress)
    noise = level * float(np.abs(signals).max())
    return at, load, signals + random.normal(size=signals.shape) * noise, noise


def beyond(load: Load, wanted: Floats) -> float:
    return float(np.abs((np.array(as_row(load)) - wanted) / load.sigma).max())


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("side", "pitch"), [(2, 2.0), (3, 1.5), (4, 2.0)])
def test_a_zero_reading_is_named_even_within_the_noise_of_the_fit(side: int, pitch: float, stress: bool) -> None:
    """Noisy readings are never exactly zero; in half of these the fit explains the false one within its noise."""
    random = np.random.default_rng((side, stress))
    for n in range(30):
        at, load, read, noise = scene(random, (side, side), pitch, 2e-2, stress)
        row, col = (int(k) for k in np.unravel_index(np.abs(read).max(axis=-1).argmax(), (side, side)))
        read[row, col, n % 2] = 0.0
        answer = found(at, read, stress, noise)
        assert (row, col) in answer.left_out
        assert answer.validity is not Validity.INSIDE or beyond(answer, load) < 5


@pytest.mark.parametrize("stress", [False, True])
def test_a_zero_of_the_field_and_coarse_steps_are_not_false_readings(stress: bool) -> None:
    line = TaxelArray("line", 1, 6, DEPTH, DEPTH).positions()
    load_aside = np.array([line[0, 4, 0], 0.4 * DEPTH, 0.03, 0.0, 0.4])
    read = measured(line, [load_aside], stress)
    assert np.count_nonzero(np.abs(read) < 1e-12 * np.abs(read).max()) == 1
    assert found(line, read, stress).left_out == ()
    random = np.random.default_rng(8)
    for _ in range(50):
        at, _, read, noise = scene(random, (4, 4), 1.0, 1e-3, stress)
        step = float(np.abs(read).max()) / 40
        rounded = np.round(read / step) * step
        assert found(at, rounded, stress, noise + step).left_out == ()
        assert found(at, rounded, stress).saturated == ()


def test_a_taxel_under_the_load_that_cannot_be_read_is_named() -> None:
    at, load, read, noise = scene(np.random.default_rng(1), (4, 4), 1.0, 1e-3, True)
    near = np.hypot(*np.moveaxis(at - load[:2], -1, 0))
    first, last = (tuple(int(k) for k in np.unravel_index(n, (4, 4))) for n in (near.argmin(), near.argmax()))
    read[first], read[last] = np.nan, np.nan
    assert found(at, read, True, noise).left_out == (first,)
    clipped = np.zeros((4, 4), bool)
    clipped[first] = True
    answer = found(at, read, True, noise, clipped)
    assert (answer.left_out, answer.saturated) == ((), (first,))


@pytest.mark.parametrize("stress", [False, True])
def test_equal_readings_at_the_end_of_the_range_are_named(stress: bool) -> None:
    """Also if the fitted load explains one of them within its noise: noisy readings are never equal."""
    random, count = np.random.default_rng(5), 0
    for _ in range(60):
        at, load, read, noise = scene(random, (3, 3), 2.0, 1e-2, stress)
        end = 0.6 * float(np.abs(read).max())
        false = np.abs(read) > end
        if not 2 <= false.sum() <= 4:
            continue
        answer = found(at, np.clip(read, -end, end), stress, noise)
        assert set(answer.saturated) == set(map(tuple, np.argwhere(false.any(axis=-1)).tolist()))
        assert answer.validity is not Validity.INSIDE or beyond(answer, load) < 5
        count += 1
    assert count >= 10


def test_two_candidates_for_the_false_reading_make_the_load_ambiguous() -> None:
    """On a line either of two readings may have the wrong sign; the loads are half a depth apart."""
    for n in (107, 228):
        one = trial("turned", np.random.default_rng((41, KINDS.index("turned"), n)), LINES)
        assert one.load.validity is Validity.AMBIGUOUS


def test_a_place_with_sigma_above_half_a_depth_is_ambiguous() -> None:
    for n in range(100):
        one = trial("turned", np.random.default_rng((35, KINDS.index("turned"), n)), LINES)
        assert not one.inside or max(one.load.sigma[:2]) <= 0.5 * DEPTH


@pytest.mark.parametrize(
    ("kind", "most"),
    [("dead", 0.02), ("silent", 0.02), ("turned", 0.02), ("clipped", 0.02), ("stuck", 0.03), ("ball", 0.03)],
)
def test_wrong_loads_on_lines_are_ambiguous(kind: str, most: float) -> None:
    trials = [trial(kind, np.random.default_rng((34, KINDS.index(kind), n)), LINES) for n in range(200)]
    assert sum(one.inside for one in trials) >= 0.65 * len(trials)
    assert sum(one.beyond for one in trials if one.known) <= most * sum(one.inside for one in trials if one.known)


def test_sound_loads_on_lines_are_inside() -> None:
    trials = [trial("sound", np.random.default_rng((33, n)), LINES) for n in range(150)]
    assert sum(one.inside for one in trials) >= 0.98 * len(trials)
    assert not any(one.load.left_out or one.load.saturated for one in trials)
