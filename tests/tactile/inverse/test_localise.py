"""Loads located from exact strains or stresses of several taxels."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.load import Load
from tactile.inverse.localise import localise
from tactile.inverse.taxel import invert_stress
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, MODULUS, PITCH, array, as_row, locate, random_load


def assert_is(load: Load, wanted: Any, place: float = 1e-12, force: float = 1e-10) -> None:
    row = np.array(as_row(load))
    assert np.abs(row[:2] - wanted[:2]).max() < place * DEPTH
    assert np.abs(row[2:] - wanted[2:]).max() < force * np.abs(wanted[2:]).max()


@pytest.mark.parametrize("size", [1e-250, 1e-160, 1e-12, 1e6, 1e160, 1e250])
def test_loads_of_any_size_are_located(size: float) -> None:
    at, wanted = array(3, 3), np.array([4.2e-3, -1.7e-3, 0.2, -0.3, 1.0])
    assert_is(locate(at, size * point_load_strain(at, DEPTH, [wanted], MODULUS)), wanted * [1, 1, size, size, size])


@pytest.mark.parametrize("shape", [(2, 2), (2, 3), (3, 3), (8, 8)])
def test_three_component_loads_whose_sign_changes_between_taxels(shape: tuple[int, int]) -> None:
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
    assert turned > 30  # the case occurred


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


def test_stress_has_one_candidate() -> None:
    at = array(2, 2)
    wanted = (4.3e-3, -1.6e-3, 0.3, -0.8, 0.2)
    x, y, z = np.moveaxis(point_load_stress(at, DEPTH, [wanted]), -1, 0)
    assert_is(localise(at, invert_stress(x, y, z, DEPTH, 0.0), None, DEPTH), np.array(wanted))


def test_three_usable_taxels_solve_equation_13() -> None:
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
        by_hand = np.linalg.solve(np.column_stack([seen, np.full(3, DEPTH)]), moments)
        assert by_hand == pytest.approx(wanted[2:], rel=1e-11, abs=1e-11)
        assert as_row(load)[2:] == pytest.approx(by_hand, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(("shape", "known"), [((1, 1), ""), ((1, 4), "Q"), ((5, 1), "R"), ((1, 2), "Q")])
def test_taxels_on_a_line_do_not_determine_all_forces(shape: tuple[int, int], known: str) -> None:
    """One taxel does not determine the shear, a line not that across it."""
    at = array(*shape)
    wanted = np.array([4.2e-3, -2.3e-3, 0.1 * (known == "Q"), 0.1 * (known == "R"), 0.4])
    load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
    assert (load.x, load.y, load.F) == pytest.approx((4.2e-3, -2.3e-3, 0.4), rel=1e-9)
    for name, value, sigma in (("Q", load.Q, load.sigma[2]), ("R", load.R, load.sigma[3])):
        assert np.isnan(value) == (name != known)
        assert np.isinf(sigma) == (name != known)
        assert name != known or value == pytest.approx(0.1, rel=1e-9)
    assert load.taxels == at.shape[0] * at.shape[1]
    assert load.validity == Validity.INSIDE


def test_rounding_does_not_make_one_taxel_ambiguous() -> None:
    """A pull elsewhere fits one taxel as well; the load is assumed to press, whatever the rounding."""
    at, random = array(1, 1), np.random.default_rng(1)
    for _ in range(200):
        wanted = np.array([*at[0, 0] + random.uniform(-2, 2, 2) * DEPTH, 0.0, 0.0, 0.4])
        load = locate(at, point_load_strain(at, DEPTH, [wanted], MODULUS))
        assert (load.x, load.y, load.F) == pytest.approx(wanted[[0, 1, 4]], rel=1e-9)
        assert load.validity in (Validity.INSIDE, Validity.OUTSIDE)
