"""Loads located from the strains or stresses of several taxels."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.load import Load
from tactile.inverse.localise import localise, three_taxels
from tactile.inverse.taxel import invert_strain, invert_stress
from tactile.inverse.validity import Validity
from tests.oracles.localise import bound, nearest

DEPTH = 1.5e-3
PITCH = 1.5e-3
MODULUS = 2.4e6


def array(rows: int, cols: int) -> NDArray[np.float64]:
    return TaxelArray("left", rows, cols, PITCH, DEPTH, origin=(4e-3, -2e-3)).positions()


def locate(at: NDArray[np.float64], strain: Any, noise: float | None = None) -> Load:
    x, y, z = np.moveaxis(np.asarray(strain), -1, 0)
    pressing, pulling = (invert_strain(x, y, z, DEPTH, MODULUS, 0.0, sign) for sign in (1, -1))
    return localise(at, pressing, pulling, DEPTH, noise)


def as_row(load: Load) -> tuple[float, ...]:
    return load.x, load.y, load.Q, load.R, load.F


def assert_is(load: Load, wanted: Any, place: float = 1e-12, force: float = 1e-10) -> None:
    row = np.array(as_row(load))
    assert np.abs(row[:2] - wanted[:2]).max() < place * DEPTH
    assert np.abs(row[2:] - wanted[2:]).max() < force * np.abs(wanted[2:]).max()


def random_load(random: np.random.Generator, rows: int, cols: int) -> NDArray[np.float64]:
    half = np.array([cols, rows]) * PITCH / 2
    place = np.array([4e-3, -2e-3]) + random.uniform(-half, half)
    return np.concatenate([place, random.normal(size=3)])


@pytest.mark.parametrize("size", [1e-250, 1e-160, 1e-12, 1e6, 1e160, 1e250])
def test_loads_of_any_size_are_located(size: float) -> None:
    at, wanted = array(3, 3), np.array([4.2e-3, -1.7e-3, 0.2, -0.3, 1.0])
    assert_is(locate(at, size * point_load_strain(at, DEPTH, [wanted], MODULUS)), wanted * [1, 1, size, size, size])


@pytest.mark.parametrize("shape", [(2, 2), (2, 3), (3, 3), (8, 8)])
def test_three_component_loads_whose_sign_turns_between_taxels(shape: tuple[int, int]) -> None:
    random = np.random.default_rng(2)
    at = array(*shape)
    turned = 0
    for _ in range(150):
        wanted = random_load(random, *shape)
        size = (at - wanted[:2]) @ wanted[2:4] + wanted[4] * DEPTH
        turned += size.min() < 0 < size.max()
        load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
        assert_is(load, wanted)
        assert load.misfit < 1e-12
        assert max(load.sigma[:2]) < 1e-12 * DEPTH
        assert load.taxels == at.shape[0] * at.shape[1]
        assert load.validity in (Validity.INSIDE, Validity.OUTSIDE)
    assert turned > 30  # the case was really asked


@given(
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda f: max(map(abs, f)) > 0.05),
    st.floats(-0.75, 0.75),
    st.floats(-0.75, 0.75),
)
def test_any_load_over_a_2_by_2_array(force: tuple[float, float, float], x: float, y: float) -> None:
    at = array(2, 2)
    wanted = np.array([4e-3 + x * PITCH, -2e-3 + y * PITCH, *force])
    load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
    if load.taxels == 4 and load.validity != Validity.AMBIGUOUS:
        assert_is(load, wanted, 1e-9, 1e-7)


def test_stress_needs_no_second_candidates() -> None:
    at = array(2, 2)
    wanted = (4.3e-3, -1.6e-3, 0.3, -0.8, 0.2)
    x, y, z = np.moveaxis(point_load_stress(at, DEPTH, [wanted]), -1, 0)
    assert_is(localise(at, invert_stress(x, y, z, DEPTH, 0.0), None, DEPTH), np.array(wanted))


def test_three_usable_taxels_give_equation_14() -> None:
    random = np.random.default_rng(4)
    at = array(2, 2)
    for _ in range(50):
        wanted = random_load(random, 2, 2)
        strain = point_load_strain(at, DEPTH, [wanted], MODULUS)
        strain[1, 0] = np.nan
        load = locate(at, strain)
        assert load.taxels == 3
        seen = at[[0, 0, 1], [0, 1, 1]] - wanted[:2]
        moments = seen @ wanted[2:4] + wanted[4] * DEPTH
        by_hand = three_taxels(seen[:, 0], seen[:, 1], moments, DEPTH)
        assert by_hand == pytest.approx(tuple(wanted[2:]), rel=1e-11, abs=1e-11)
        assert as_row(load)[2:] == pytest.approx(by_hand, rel=1e-11, abs=1e-11)


def test_equation_14_solves_equation_13() -> None:
    x, y, z = np.array([1.0, -2.0, 0.5]), np.array([0.3, 1.0, -4.0]), 0.7
    m = np.array([2.0, -1.0, 0.25])
    q, r, f = three_taxels(x, y, m, z)
    assert q * x + r * y + f * z == pytest.approx(m, rel=1e-13)
    with pytest.raises(InputError, match="on one line"):
        three_taxels((0, 1, 2), (0, 1, 2), m, z)
    with pytest.raises(InputError, match="three taxels wanted"):
        three_taxels((0, 1), (0, 1), (0, 1), z)


def test_noise_of_one_percent_is_not_blown_up() -> None:
    """A far taxel's tiny signal must not spoil the answer: with more taxels it only gets better."""
    random = np.random.default_rng(7)
    for shape in ((2, 2), (8, 8)):
        at = array(*shape)
        place, force = [], []
        for _ in range(100):
            wanted = np.array([4.2e-3, -2.3e-3, 0.1, -0.05, 0.3])
            strain = point_load_strain(at, DEPTH, [wanted], MODULUS)
            strain += random.normal(size=strain.shape) * 0.01 * np.abs(strain).max()
            load = np.array(as_row(locate(at, strain)))
            place.append(np.hypot(*(load - wanted)[:2]) / DEPTH)
            force.append(np.abs((load - wanted)[2:]).max() / 0.3)
        assert np.quantile(place, 0.95) < 0.03
        assert np.quantile(force, 0.95) < 0.1


@pytest.mark.parametrize(("shape", "told"), [((1, 1), ""), ((1, 4), "Q"), ((5, 1), "R"), ((1, 2), "Q")])
def test_taxels_on_a_line_say_what_they_cannot_tell(shape: tuple[int, int], told: str) -> None:
    """One taxel tells no shear at all, a line none across it; everything else comes from all of them."""
    at = array(*shape)
    wanted = np.array([4.2e-3, -2.3e-3, 0.1 * (told == "Q"), 0.1 * (told == "R"), 0.4])
    load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
    assert (load.x, load.y, load.F) == pytest.approx((4.2e-3, -2.3e-3, 0.4), rel=1e-9)
    for name, value, sigma in (("Q", load.Q, load.sigma[2]), ("R", load.R, load.sigma[3])):
        assert np.isnan(value) == (name != told)
        assert np.isinf(sigma) == (name != told)
        assert name != told or value == pytest.approx(0.1, rel=1e-9)
    assert load.taxels == at.shape[0] * at.shape[1]
    assert load.validity == Validity.INSIDE


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


SCALE = np.array([DEPTH, DEPTH, 1.0, 1.0, 1.0])


def felt(at: NDArray[np.float64], loads: Any, stress: bool) -> NDArray[np.float64]:
    return point_load_stress(at, DEPTH, loads) if stress else point_load_strain(at, DEPTH, loads, MODULUS)


def found(at: NDArray[np.float64], signals: NDArray[np.float64], stress: bool, noise: float | None = None) -> Load:
    """``noise``: of the signals, in their unit."""
    if not stress:
        return locate(at, signals, None if noise is None else noise * 4 * np.pi / 3 * MODULUS * DEPTH**2)
    x, y, z = np.moveaxis(signals, -1, 0)
    planes = invert_stress(x, y, z, DEPTH, 0.0)
    return localise(at, planes, None, DEPTH, None if noise is None else noise * 2 * np.pi / 3 * DEPTH**2)


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("shape", [(2, 2), (3, 3), (8, 8)])
def test_the_answer_is_that_of_least_squares(shape: tuple[int, int], stress: bool) -> None:
    random, at = np.random.default_rng(5), array(*shape)
    for _ in range(20):
        wanted = random_load(random, *shape) * [1, 1, 0.2, 0.2, 0] + [0, 0, 0, 0, 1]
        signals = felt(at, [wanted], stress)
        signals = signals + random.normal(size=signals.shape) * np.abs(signals).max() * 0.01
        load, best = found(at, signals, stress), nearest(lambda p: felt(at, p, stress), signals, wanted[None], SCALE)[0]
        assert np.abs((np.array(as_row(load)) - best) / SCALE).max() < 2e-3


def test_taxels_on_a_line_use_all_of_them() -> None:
    """Errors near the bound of an estimate of x, y, Q and F."""
    random, wanted, at = np.random.default_rng(3), np.array([4.2e-3, -2.3e-3, 0.1, 0.0, 0.4]), array(1, 9)
    strain = felt(at, [wanted], False)
    noise, errors = 0.01 * float(np.abs(strain).max()), []
    for _ in range(200):
        load = locate(at, strain + random.normal(size=strain.shape) * noise)
        errors.append(np.array(as_row(load))[[0, 1, 2, 4]] - wanted[[0, 1, 2, 4]])
    least = bound(lambda p: felt(at, p, False), wanted, noise, SCALE, (0, 1, 2, 4))
    assert (np.sqrt(np.mean(np.square(errors), axis=0)) < 1.2 * least).all()


@pytest.mark.parametrize("given_noise", [False, True])
@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize(("side", "level"), [(2, 1e-6), (2, 3e-2), (4, 1e-3), (8, 3e-2), (32, 1e-2), (32, 3e-2)])
def test_errors_are_near_the_cramer_rao_bound_and_known(
    side: int, level: float, stress: bool, given_noise: bool
) -> None:
    random, at = np.random.default_rng(side), array(side, side)
    ratio, own = [], []
    for _ in range(60 if side < 32 else 25):
        wanted = random_load(random, side, side) * [1, 1, 0.1, 0.1, 0] + [0, 0, 0, 0, 1]
        signals = felt(at, [wanted], stress)
        noise = level * float(np.abs(signals).max())
        noisy = signals + random.normal(size=signals.shape) * noise
        load = found(at, noisy, stress, noise if given_noise else None)
        error = (np.array(as_row(load)) - wanted)[:2]
        ratio.append(error / bound(lambda p: felt(at, p, stress), wanted, noise, SCALE)[:2])
        own.append(error / load.sigma[:2])
    assert np.sqrt(np.mean(np.square(ratio))) < 1.3
    assert np.mean(np.abs(own) < 2) > 0.85
    assert np.mean(np.abs(own) < 0.5) < 0.6


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


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("count", [2, 3])
def test_loads_well_apart_are_told_apart(count: int, stress: bool) -> None:
    random, at, right = np.random.default_rng(count), array(8, 8), 0
    for _ in range(40):
        gap = 0.0
        while gap < 2.2 * DEPTH:
            loads = np.array([random_load(random, 8, 8) * [1, 1, 0.05, 0.05, 0] for _ in range(count)])
            gap = min(np.hypot(*(a - b)[:2]) for k, a in enumerate(loads) for b in loads[:k])
        loads[:, 4] = random.uniform(0.15, 0.4, count)
        signals = felt(at, loads, stress)
        load = found(at, signals + random.normal(size=signals.shape) * 0.005 * np.abs(signals).max(), stress)
        places = np.array([(one.x, one.y) for one in (load, *load.others)])
        near = [np.hypot(*(places - one[:2]).T).min() < 0.2 * DEPTH for one in loads]
        right += len(places) == count and all(near)
        assert len(places) == count or load.validity in (Validity.NOT_ONE, Validity.AMBIGUOUS)
    assert right >= 38


def test_two_loads_are_not_one_between_them() -> None:
    at = TaxelArray("pad", 8, 8, PITCH, DEPTH).positions()
    load = found(at, felt(at, [(-2e-3, 0, 0, 0, 0.3), (2e-3, 0, 0, 0, 0.3)], True), True)
    assert sorted(one.x for one in (load, *load.others)) == pytest.approx([-2e-3, 2e-3])
    assert [one.F for one in (load, *load.others)] == pytest.approx([0.3, 0.3])


@pytest.mark.parametrize("stress", [False, True])
def test_a_wide_patch_is_no_point_load(stress: bool) -> None:
    at = array(8, 8)
    edge = np.linspace(-2.5, 2.5, 12) * DEPTH
    patch = np.array([[4e-3 + x, -2e-3 + y, 0, 0, 0.01] for x in edge for y in edge])
    load = found(at, felt(at, patch, stress), stress)
    assert load.validity == Validity.NOT_ONE
    assert load.misfit > 0.25
