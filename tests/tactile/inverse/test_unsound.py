"""Loads that are not points on a half-space: their validity, and that their uncertainty covers the error."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import FieldQuantity, Medium
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, MODULUS, as_row, found, measured
from tests.oracles.elastic.layer import layer_load
from tests.tactile.inverse.trials import KINDS, ball, point_signals, trial

WANTED = np.array([0.2e-3, -0.4e-3, 0.05, -0.08, 0.4])


def pad(side: int, pitch: float = 1.0) -> Floats:
    return TaxelArray("pad", side, side, pitch * DEPTH, DEPTH).positions()


def located(
    at: Floats, signals: Floats, level: float, stress: bool, spoil: object = None, *, known: bool = True
) -> Load:
    """Return the located load of signals with relative noise ``level``; ``spoil`` changes the readings."""
    noise = level * float(np.abs(signals).max())
    read = signals + np.random.default_rng(3).normal(size=signals.shape) * noise
    if callable(spoil):
        read = spoil(read)
    return found(at, read, stress, noise if known else None)


def beyond(load: Load, wanted: Floats = WANTED) -> float:
    """Return the largest error of the load over its standard deviation."""
    return float(np.abs((np.array(as_row(load)) - wanted) / load.sigma).max())


@pytest.mark.parametrize(
    ("kind", "most"),
    [
        *((kind, 0.02) for kind in ("dead", "silent", "turned", "clipped", "stuck", "second")),
        ("layer", 0.04),
        ("ball", 0.03),
    ],
)
def test_deviations_cover_the_model_error(kind: str, most: float) -> None:
    """Fraction of INSIDE loads beyond 5 deviations; for deviations by noise alone it is 13 to 60 %."""
    trials = [
        trial(kind, np.random.default_rng((31, KINDS.index(kind), n))) for n in range(100 if kind == "layer" else 250)
    ]
    inside = [one for one in trials if one.inside]
    assert len(inside) >= 0.6 * len(trials)
    assert np.mean([one.sigmas.max() > 5 for one in inside]) <= most


def test_sound_loads_reach_the_cramer_rao_bound_with_honest_deviations() -> None:
    trials = [trial("sound", np.random.default_rng((32, n))) for n in range(200)]
    known = [one for one in trials if one.known]
    own = np.array([one.sigmas[:2] for one in known])
    assert sum(not one.inside for one in trials) <= 2
    assert np.median(np.abs([one.over_bound for one in known])) / 0.6745 < 1.15
    assert np.mean(own < 1) == pytest.approx(0.68, abs=0.07)
    assert np.mean(own < 2) == pytest.approx(0.95, abs=0.05)
    assert not any(one.load.left_out or one.load.saturated or one.load.others for one in trials)


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("factor", [0.0, -1.0])
@pytest.mark.parametrize(("side", "pitch"), [(2, 1.0), (8, 1.5)])
def test_one_false_reading_is_named_and_the_others_of_its_taxel_are_used(
    side: int, pitch: float, factor: float, axis: int, known: bool, stress: bool
) -> None:
    at = pad(side, pitch)
    place = at[side // 2, side // 2] + (0.25 * DEPTH, -0.3 * DEPTH)
    wanted = np.array([*place, 0.05, -0.08, 0.4])
    signals = measured(at, [wanted], stress)
    row, col = np.unravel_index(np.abs(signals).max(axis=-1).argmax(), (side, side))

    def spoil(read: Floats) -> Floats:
        read[row, col, axis] *= factor
        return read

    load = located(at, signals, 1e-4, stress, spoil, known=known)
    unread = stress and axis == 2 and factor == 0  # a taxel without normal stress gives no place
    assert load.left_out == ((row, col),)
    assert (load.taxels + unread, load.saturated, load.others, load.validity) == (side * side, (), (), Validity.INSIDE)
    assert np.abs(np.array(as_row(load))[:2] - place).max() < 2e-3 * DEPTH
    assert beyond(load, wanted) < 5


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize(
    ("side", "pitch", "taxel", "place", "clipped", "level"),
    [
        (2, 1.8, (1, 0), (0.15, 0.1), ((1, 0),), 1e-5),
        (4, 1.0, (1, 2), (0.5, 0.05), ((1, 2), (1, 3)), 0.02),  # noisy readings are equal only at the end of the range
    ],
)
def test_clipped_readings_are_named(
    side: int, pitch: float, taxel: tuple[int, int], place: tuple[float, float], clipped: tuple[tuple[int, int], ...],
    level: float, known: bool, stress: bool,
) -> None:  # fmt: skip
    at = pad(side, pitch)
    wanted = np.array([*at[taxel] + np.array(place) * DEPTH, 0.02, -0.03, 0.4])
    signals = measured(at, [wanted], stress)
    end = np.sort(np.abs(signals).ravel())[-len(clipped)] * 0.7
    load = located(at, signals, level, stress, lambda read: np.clip(read, -end, end), known=known)
    assert (set(load.saturated), load.left_out) == (set(clipped), ())
    assert beyond(load, wanted) < 5


@pytest.mark.parametrize("stress", [False, True])
def test_equal_exact_readings_are_not_clipped(stress: bool) -> None:
    load = found(pad(4), measured(pad(4), [(0.0, 0.0, 0.0, 0.0, 0.4)], stress), stress)
    assert (load.saturated, load.taxels) == ((), 16)


@pytest.mark.parametrize("pitch", [1.0, 1.5])
def test_a_ball_over_one_taxel_of_a_line_is_not_a_false_taxel(pitch: float) -> None:
    """All but the nearest taxel fit a point load: it reads falsely, or the tip is wide."""
    at = TaxelArray("line", 1, 9, pitch * DEPTH, DEPTH).positions()
    for radius in (0.6, 0.75, 0.9):
        wanted = np.array([0.1 * DEPTH, 0.3 * DEPTH, 0.2, 0.0, 0.9])
        load = located(at, point_signals(at, ball(wanted, radius * DEPTH), False), 1e-3, False)
        inside, known_axes = load.validity is Validity.INSIDE, [0, 1, 2, 4]
        assert not (inside and load.left_out)
        assert not inside or (np.abs(np.array(as_row(load)) - wanted) / load.sigma)[known_axes].max() < 5


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("part", [0.05, 0.1])
@pytest.mark.parametrize("side", [4, 8])
def test_a_weak_second_load_is_located(side: int, part: float, stress: bool) -> None:
    at, second = pad(side), np.array([0.2e-3 + 1.2 * DEPTH, -0.4e-3 - 2.0 * DEPTH, 0.0, 0.0, part * 0.4])
    load = located(at, point_signals(at, np.array([WANTED, second]), stress), 1e-5, stress)
    assert len(load.others) == 1
    for one, wanted in zip((load, *load.others), (WANTED, second), strict=True):
        assert one.validity is Validity.INSIDE
        assert beyond(one, wanted) < 5
    assert load.misfit == 0


@pytest.mark.parametrize("quantity", ["strain", "stress"])
@pytest.mark.parametrize("side", [4, 8])
def test_the_force_on_a_thinner_cover_than_assumed_has_a_large_sigma(side: int, quantity: FieldQuantity) -> None:
    at, cover = pad(side), Medium(MODULUS, quantity=quantity)
    load = located(at, layer_load(at, DEPTH, WANTED[None], 1.2 * DEPTH, cover), 1e-5, quantity == "stress")
    assert abs(load.F / WANTED[4] - 1) > 0.15
    assert beyond(load) < 2 < 4 < beyond(replace(load, sigma=load.scatter))


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("side", "pitch"), [(2, 1.0), (4, 1.0), (8, 0.5)])
@pytest.mark.parametrize("radius", [0.2, 0.5])
def test_a_ball_is_ordinary_touch(radius: float, side: int, pitch: float, stress: bool) -> None:
    """It is one load inside without false readings; only noise changes from frame to frame."""
    at = pad(side, pitch)
    load = located(at, point_signals(at, ball(WANTED, radius * DEPTH), stress), 1e-3, stress)
    assert (load.validity, load.left_out, load.saturated, load.others) == (Validity.INSIDE, (), (), ())
    assert max(load.sigma[:2]) < 0.2 * DEPTH
    assert max(load.scatter[:2]) < 0.3 * max(load.sigma[:2])
    assert np.abs(np.array(as_row(load)) - WANTED)[:2].max() < 5 * max(load.sigma[:2])
