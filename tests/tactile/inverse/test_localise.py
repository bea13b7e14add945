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
from tactile.inverse.localise import Load, localise, three_taxels
from tactile.inverse.taxel import invert_strain, invert_stress
from tactile.inverse.validity import Validity
from tests.oracles.localise import localise as plain

DEPTH = 1.5e-3
PITCH = 1.5e-3
MODULUS = 2.4e6


def array(rows: int, cols: int) -> NDArray[np.float64]:
    return TaxelArray("left", rows, cols, PITCH, DEPTH, origin=(4e-3, -2e-3)).positions()


def locate(at: NDArray[np.float64], strain: Any) -> Load:
    x, y, z = np.moveaxis(np.asarray(strain), -1, 0)
    pressing, pulling = (invert_strain(x, y, z, DEPTH, MODULUS, 0.0, sign) for sign in (1, -1))
    return localise(at, pressing, pulling, DEPTH)


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
        assert load.residual < 1e-12 * DEPTH
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


@pytest.mark.parametrize("shape", [(1, 1), (1, 4), (5, 1), (1, 2)])
def test_taxels_on_a_line_say_what_one_taxel_can(shape: tuple[int, int]) -> None:
    at = array(*shape)
    wanted = (4.2e-3, -2.3e-3, 0.0, 0.0, 0.4)
    load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
    assert (load.x, load.y, load.F) == pytest.approx((4.2e-3, -2.3e-3, 0.4), rel=1e-12)
    assert np.isnan((load.Q, load.R, load.residual)).all()
    assert load.taxels == 1
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
    assert alone.taxels == 1
    assert (alone.x, alone.y) == pytest.approx(wanted[:2])
    none = np.zeros((2, 2))
    with pytest.raises(InputError, match=r"\(2, 2\) for an array of \(3, 3\)"):
        localise(array(3, 3), (none, none, none, none), None, DEPTH)


def test_a_place_that_does_not_stand_out_is_called_ambiguous() -> None:
    """Four taxels with unrelated strains: no load explains them, and the answer must not look sure."""
    at = array(2, 2)
    random = np.random.default_rng(11)
    codes = [locate(at, random.normal(size=(2, 2, 3)) * 1e-3).validity for _ in range(50)]
    assert codes.count(Validity.AMBIGUOUS) > 15


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("shape", [(1, 1), (1, 4), (2, 2), (3, 3), (8, 8)])
def test_compiled_loops_agree_with_plain_arrays(shape: tuple[int, int], stress: bool) -> None:
    """On noise, on one load, on two, with taxels missing: every branch and near ties."""
    random, at, seen = np.random.default_rng(5), array(*shape), set()
    for n in range(120):
        loads = [random_load(random, *shape) for _ in range(n % 3)]
        if stress:
            signals = point_load_stress(at, DEPTH, loads) if loads else np.zeros((*shape, 3))
            floor = 1e-3 * np.abs(signals).max()
        else:
            signals = point_load_strain(at, DEPTH, loads, MODULUS) if loads else np.zeros((*shape, 3))
            floor = 1e-3 * np.abs(signals).max() if n % 2 else 0.0
        signals = signals + random.normal(size=signals.shape) * np.abs(signals).max() * 0.05 * (n % 4)
        signals[random.random(shape) < 0.1] = np.nan if n % 5 == 0 else 0.0
        x, y, z = np.moveaxis(signals, -1, 0)
        if stress:
            pressing, pulling = invert_stress(x, y, z, DEPTH, floor), None
        else:
            pressing, pulling = (invert_strain(x, y, z, DEPTH, MODULUS, floor, sign) for sign in (1, -1))
        got, wanted = localise(at, pressing, pulling, DEPTH), plain(at, pressing, pulling, DEPTH)
        seen.add(got.validity)
        assert (got.taxels, got.validity) == (wanted.taxels, wanted.validity)
        assert as_row(got) == pytest.approx(as_row(wanted), rel=1e-7, abs=1e-9, nan_ok=True)
        assert got.residual == pytest.approx(wanted.residual, rel=1e-6, abs=1e-12, nan_ok=True)
    assert len(seen) >= (2 if shape == (1, 1) else 3)
