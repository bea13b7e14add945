"""Inverse of one taxel, as NumPy function and as compiled kernel: every case runs with both."""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.operations import cellwise
from cnnsim.operations.cellwise import Cellwise, Planes
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.taxel import STRAIN_INVERSE, STRESS_INVERSE
from tactile.inverse.validity import Validity
from tests.benchmarks.accuracy.inverse import forms
from tests.oracles.elastic.one_taxel import solve

DEPTH = 2e-4
MODULUS = 2.4e6
RING = np.sqrt(2.0)
Run = Callable[..., Planes]


def law(operation: Cellwise, planes: Any, *parameters: float) -> Planes:
    return operation.array(*planes, *parameters)


def kernel(operation: Cellwise, planes: Any, *parameters: float) -> Planes:
    planes = [np.ascontiguousarray(plane) for plane in planes]
    outputs = tuple(np.full_like(planes[0], np.nan) for _ in operation.outputs)
    assert operation.compiled is not None
    operation.compiled()(*planes, *outputs, *parameters)
    return outputs


runs = pytest.mark.parametrize("run", [law, kernel])
dtypes = pytest.mark.parametrize(("dtype", "bound"), [(np.float64, 1e-12), (np.float32, 2e-6)])
operations = pytest.mark.parametrize("operation", [STRAIN_INVERSE, STRESS_INVERSE], ids=lambda op: op.name)


def positions() -> NDArray[np.float64]:
    """Return places from 0 to 10 depths away, dense near the ring, in all directions."""
    near_ring = RING * (1 + np.concatenate([-np.logspace(-15, -1, 60), [0.0], np.logspace(-15, -1, 60)]))
    rho = np.concatenate([[0.0], np.logspace(-9, 1, 500), np.linspace(0.01, 10, 2000), near_ring])
    azimuth = np.random.default_rng(0).uniform(-np.pi, np.pi, rho.size)
    at: NDArray[np.float64] = rho[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    return DEPTH * at


def signals(operation: Cellwise, at: Any, load: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return signals (3, n) of taxels at ``at`` under the load (Q, R, F) at the origin."""
    loads = [(0.0, 0.0, *load)]
    if operation is STRAIN_INVERSE:
        return np.ascontiguousarray(point_load_strain(at, DEPTH, loads, MODULUS).T)
    return np.ascontiguousarray(point_load_stress(at, DEPTH, loads).T)


def parameters(operation: Cellwise, floor: float = 0.0, pressing: int = 1) -> tuple[float, ...]:
    return (DEPTH, MODULUS, floor, pressing) if operation is STRAIN_INVERSE else (DEPTH, floor)


@runs
@dtypes
@operations
def test_round_trip_from_zero_to_ten_depths(run: Run, dtype: Any, bound: float, operation: Cellwise) -> None:
    """The location's error is relative to rho itself, down to rho = 1e-9 z; the force's to the force."""
    at = positions()
    dx, dy, force, validity = run(operation, signals(operation, at, (0, 0, 0.02)).astype(dtype), *parameters(operation))
    assert dx.dtype == dy.dtype == force.dtype == validity.dtype == dtype
    rho = np.hypot(*at.T)
    # the load is at the taxel's place plus (dx, dy), here at the origin
    assert (np.hypot(dx + at[:, 0], dy + at[:, 1]) <= bound * rho).all()
    assert np.abs(force / 0.02 - 1).max() < bound
    off_ring = np.abs(rho / (RING * DEPTH) - 1) > 1e-6
    wanted = np.where(rho < RING * DEPTH, Validity.INSIDE, Validity.OUTSIDE)
    assert np.array_equal(validity[off_ring], wanted[off_ring])
    assert np.isin(validity, (Validity.INSIDE, Validity.OUTSIDE)).all()


@runs
@dtypes
def test_exactly_on_the_ring(run: Run, dtype: Any, bound: float) -> None:
    planes = np.array([[3.0, -3.0, 0.0], [4.0, 0.0, -4.0], [0.0, 0.0, 0.0]], dtype) * dtype(1e-4)
    dx, dy, force, validity = run(STRAIN_INVERSE, planes, DEPTH, MODULUS, 0.0, 1)
    rho = RING * DEPTH
    assert dx == pytest.approx((rho * 0.6, -rho, 0), rel=bound)
    assert dy == pytest.approx((rho * 0.8, 0, -rho), rel=bound)
    # eq. (1) at rho = sqrt(2) z: |u_xz| = 3 F 3 sqrt(2) / (4 pi E z^2 3^(5/2))
    wanted = np.array([5e-4, 3e-4, 4e-4]) * 4 * np.pi * MODULUS * DEPTH**2 * 3**2.5 / (9 * RING)
    assert force == pytest.approx(wanted, rel=bound)
    assert (validity == Validity.OUTSIDE).all()


@runs
@pytest.mark.parametrize("sign", [1, -1])
def test_random_strains_agree_with_root_finding(run: Run, sign: int) -> None:
    planes = np.random.default_rng(5).normal(size=(3, 200)) * 1e-3
    dx, dy, force, _ = run(STRAIN_INVERSE, planes, DEPTH, MODULUS, 0.0, sign)
    wanted = np.array([solve(x, y, z, DEPTH, MODULUS, sign) for x, y, z in planes.T])
    assert np.abs(np.stack([dx, dy, force], axis=-1) / wanted - 1).max() < 1e-12


@runs
@operations
@pytest.mark.parametrize(("x", "y"), [(1, 1), (-1, 1), (-1, -1), (1, -1)])
def test_four_quadrants(run: Run, operation: Cellwise, x: int, y: int) -> None:
    load = np.array([x * 5e-5, y * 7e-5])
    dx, dy, *_ = run(operation, signals(operation, -load[None], (0, 0, 0.02)), *parameters(operation))
    assert (dx[0], dy[0]) == pytest.approx(tuple(load), rel=1e-12)


@runs
def test_two_candidates_of_a_load_that_may_pull(run: Run) -> None:
    at = np.array([(6e-5, 2e-5), (-5e-4, 1e-4), (3e-5, -9e-5)])
    for load in ((0, 0, -0.02), (0.05, -0.03, 0.002), (0, 0, 0.02)):
        planes = signals(STRAIN_INVERSE, at, load)
        presses, pulls, open_ = (run(STRAIN_INVERSE, planes, DEPTH, MODULUS, 0.0, p) for p in (1, -1, 0))
        assert (open_[3] == Validity.AMBIGUOUS).all()
        for plane, same in zip(open_[:3], presses[:3], strict=True):
            assert np.array_equal(plane, same)
        assert (presses[2] > 0).all()
        assert (pulls[2] < 0).all()
        assert (presses[3] != pulls[3]).all()  # one inside, one outside
        assert np.hypot(presses[0], presses[1]) * np.hypot(pulls[0], pulls[1]) == pytest.approx(2 * DEPTH**2)
        size = (at @ load[:2] + load[2] * DEPTH) / DEPTH
        right = np.where(size > 0, presses[:3], pulls[:3])
        assert right == pytest.approx(np.array([-at[:, 0], -at[:, 1], size]), rel=1e-11)


@runs
def test_stress_gives_the_sign(run: Run) -> None:
    at = np.array([(6e-5, 2e-5), (-5e-4, 1e-4)])
    dx, dy, force, validity = run(STRESS_INVERSE, signals(STRESS_INVERSE, at, (0, 0, -0.02)), DEPTH, 0.0)
    assert np.array([dx, dy]) == pytest.approx(-at.T, rel=1e-12)
    assert force == pytest.approx(-0.02, rel=1e-12)
    assert validity.tolist() == [Validity.INSIDE, Validity.OUTSIDE]


@runs
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_no_finite_answer(run: Run, dtype: Any) -> None:
    """On the axis: unique if the load may pull; a contradiction if it presses and u_zz > 0."""
    planes = np.array([[0, 0], [0, 0], [-1e-3, 1e-3]], dtype)
    for pressing, wanted in ((1, [1, 4]), (-1, [4, 1]), (0, [1, 1])):
        dx, dy, force, validity = run(STRAIN_INVERSE, planes, DEPTH, MODULUS, 0.0, pressing)
        assert validity.tolist() == wanted
        assert not dx.any()
        assert not dy.any()
        assert ((force != 0) == (validity == 1)).all()
    assert (force[0], force[1]) == pytest.approx((force[0], -force[0]))
    far = run(STRESS_INVERSE, np.array([[1, 0], [0, 1], [0, 0]], dtype), DEPTH, 0.0)
    assert far[3].tolist() == [Validity.INVALID] * 2
    assert not np.any(far[:3])


@runs
@operations
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("broken", [np.nan, -np.inf])
def test_a_broken_taxel_is_marked_alone(run: Run, operation: Cellwise, dtype: Any, broken: float) -> None:
    whole = signals(operation, positions(), (0, 0, 0.02)).astype(dtype)
    before = run(operation, whole, *parameters(operation))
    some = np.arange(5, whole.shape[1], 7)
    hurt = whole.copy()
    for component in range(3):
        hurt[component, some[component::3]] = dtype(broken)
    after = run(operation, hurt, *parameters(operation))
    assert (after[3][some] == Validity.INVALID).all()
    assert not np.any([plane[some] for plane in after[:3]])
    others = np.ones(whole.shape[1], bool)
    others[some] = False
    for was, is_ in zip(before, after, strict=True):
        assert np.array_equal(was[others], is_[others])


@runs
@operations
def test_floor_and_no_load(run: Run, operation: Cellwise) -> None:
    planes = np.array([[0, 1e-5, -1e-5, 0, 2e-5], [0, 0, 0, 1e-5, 0], [0, 0, 1e-6, -1e-5, -3e-6]])
    *values, validity = run(operation, planes, *parameters(operation, floor=1e-5))
    assert validity[:4].tolist() == [Validity.NO_LOAD] * 4
    assert validity[4] in (Validity.INSIDE, Validity.OUTSIDE)
    assert not np.any([value[:4] for value in values])
    validity = run(operation, planes, *parameters(operation))[3]
    assert validity[0] == Validity.NO_LOAD
    assert (validity[1:] != Validity.NO_LOAD).all()


@runs
@operations
@pytest.mark.parametrize(
    ("dtype", "scales", "bound"), [(np.float32, (1e-30, 1e30), 1e-6), (np.float64, (1e-290, 1e290), 1e-14)]
)
def test_tiny_and_huge_signals(
    run: Run, operation: Cellwise, dtype: Any, scales: tuple[float, float], bound: float
) -> None:
    planes = signals(operation, positions(), (0, 0, 1.0))
    planes /= np.abs(planes).max(0)
    usual = run(operation, planes.astype(dtype), *parameters(operation))
    for scale in scales:
        scaled = run(operation, (planes * scale).astype(dtype), *parameters(operation))
        # rounding may change the region only on the ring itself
        assert np.abs(np.hypot(*positions()[usual[3] != scaled[3]].T) / (RING * DEPTH) - 1).max(initial=0) < 1e-6
        for was, is_, factor in zip(usual[:3], scaled[:3], (1, 1, dtype(scale)), strict=True):
            # relative to the largest: rounding the scaled strains changes tiny components
            assert np.abs(is_ / factor - was).max() <= bound * 10 * np.abs(was).max()


def test_any_shape_and_integers() -> None:
    planes = np.array([3, 4, 0]).repeat(4).reshape(3, 2, 2)
    dx, dy, *_ = STRAIN_INVERSE.array(*planes, 1.0, 1.0, 0.0, 1.0)
    assert dx.shape == (2, 2)
    assert (dx[0, 0], dy[1, 1]) == pytest.approx((RING * 0.6, RING * 0.8), rel=1e-14)


def test_both_are_registered_and_numba_is_imported_late() -> None:
    assert cellwise.find("strain-inverse") is STRAIN_INVERSE
    assert cellwise.find("stress-inverse") is STRESS_INVERSE
    code = "import sys, tactile.inverse.taxel; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_stable_form_keeps_the_digits_that_the_printed_one_loses() -> None:
    """Against high precision; numbers of the accuracy page."""
    worst: dict[str, float] = {}
    for row in forms():
        worst[row["way"]] = max(worst.get(row["way"], 0.0), row["error"])
    assert worst["stable, float64"] < 2e-15
    assert worst["stable, float32"] < 1e-6
    assert worst["printed, float64"] > 0.1
    assert worst["printed, float32"] > 0.1
