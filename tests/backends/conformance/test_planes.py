"""Verbs for planes: load, read, convert, output, logic, neighbourhood, count."""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cnnsim import Boundary, fixed
from cnnsim.backends.base import Backend
from cnnsim.operations.bitwise import BitLiteral, BitRule
from cnnsim.operations.logic import FUNCTIONS
from tests.kits.backends import REFERENCE
from tests.kits.networks import REPEATING

BOUNDARIES = (fixed(-1), fixed(1), *REPEATING)
SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 200)) | st.tuples(
    st.integers(1, 3), st.integers(1, 5), st.integers(1, 70)
)
WIDE = [(1, 1), (2, 3), (7, 64), (2, 9, 131), (4, 67), (2, 13, 704), (12, 771), (13, 1276)]


def black_and_white(shape: tuple[int, ...], seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.random(shape) > 0.4, rng.random(shape) > 0.6]


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (2, 4, 65), (2, 3, 4, 5)])
def test_numbers_go_in_and_come_out(backend: Backend, shape: tuple[int, ...]) -> None:
    numbers = np.random.default_rng(1).normal(size=shape)
    given, wanted = numbers.copy(), numbers.astype(backend.dtype)
    plane = backend.load(given, "lam")
    given[:] = 0  # what happens to the array afterwards is no business of the plane
    found = backend.read(plane)
    assert found.dtype == backend.dtype
    assert np.array_equal(found, wanted)
    found[:] = 0
    assert np.array_equal(backend.read(plane), wanted)


def test_black_is_above_zero(backend: Backend) -> None:
    numbers = np.array([[-1.0, -1e-30, 0.0, 1e-30, 0.5, 1.0]])
    found = backend.read(backend.load(numbers, "llm"))
    assert found.dtype == np.bool_
    assert found.tolist() == [[False, False, False, True, True, True]]
    assert np.array_equal(backend.read(backend.convert(backend.load(numbers, "lam"), "llm")), found)


@settings(max_examples=60)
@given(shape=SHAPES, seed=st.integers(0, 99))
@example((1, 1), 5)
@example((3, 63), 5)
@example((5, 64), 5)
@example((2, 3, 65), 5)
@example((300, 130), 5)
def test_packing_logic_and_counting(backend: Backend, shape: tuple[int, ...], seed: int) -> None:
    p, q = black_and_white(shape, seed)
    planes = backend.load(p, "llm"), backend.load(q, "llm")
    np.testing.assert_array_equal(backend.read(planes[0]), p)
    lam = backend.convert(planes[0], "lam")
    np.testing.assert_array_equal(backend.read(lam), np.where(p, 1, -1))
    np.testing.assert_array_equal(backend.read(backend.convert(lam, "llm")), p)
    np.testing.assert_array_equal(backend.read(backend.convert(backend.load(np.where(p, 0.1, 0.0), "lam"), "llm")), p)
    for function in range(len(FUNCTIONS)):
        got, want = backend.logic(function, *planes), REFERENCE.logic(function, p, q)
        np.testing.assert_array_equal(backend.read(got), want)
        np.testing.assert_array_equal(backend.count(got), REFERENCE.count(want))  # no stray bits beyond the last column


@pytest.mark.parametrize("shape", [(3, 64), (2, 5, 200), (7, 129)])
@pytest.mark.parametrize("dtype", ["bool", "int8", "float32", "float64"])
def test_numbers_of_any_kind_are_black_above_zero(backend: Backend, dtype: Any, shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(9)
    numbers = (rng.integers(0 if dtype in ("bool", "uint8") else -3, 4, shape) // 2).astype(dtype)
    if dtype.startswith("float"):
        numbers[..., ::7], numbers[..., 1::9], numbers[..., 2::11] = np.nan, np.inf, -0.0
        numbers[..., 3::5] *= np.finfo(dtype).tiny
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        planes = [backend.load(numbers, "llm"), backend.convert(backend.load(numbers, "lam"), "llm")]
        wanted = [numbers > 0, numbers.astype(backend.dtype) > 0]
    for plane, black in zip(planes, wanted, strict=True):
        np.testing.assert_array_equal(backend.read(plane), black)
        np.testing.assert_array_equal(backend.count(plane), black.sum((-2, -1)))


def test_a_batch_is_counted_grid_by_grid(backend: Backend) -> None:
    p = np.array([[[True, True, False]], [[False, False, True]]])
    count = backend.count(backend.load(p, "llm"))
    assert isinstance(count, np.ndarray)
    assert count.tolist() == [2, 1]
    one = backend.count(backend.load(p[0], "llm"))
    assert isinstance(one, int)
    assert one == 2


def compare(backend: Backend, rule: BitRule, boundary: Boundary, p: np.ndarray) -> None:
    got, want = (
        backend.neighbourhood(rule, boundary, backend.load(p, "llm")),
        REFERENCE.neighbourhood(rule, boundary, p),
    )
    np.testing.assert_array_equal(backend.read(got), want)
    np.testing.assert_array_equal(backend.count(got), REFERENCE.count(want))


@settings(max_examples=100)
@given(
    shape=SHAPES,
    boundary=st.sampled_from(BOUNDARIES),
    literals=st.lists(st.tuples(st.integers(-5, 5), st.integers(-5, 5), st.booleans()), max_size=6),
    conjunction=st.booleans(),
    seed=st.integers(0, 99),
)
def test_neighbourhoods(
    backend: Backend,
    shape: tuple[int, ...],
    boundary: Boundary,
    literals: list[tuple[int, int, bool]],
    conjunction: bool,
    seed: int,
) -> None:
    rule = BitRule(tuple(itertools.starmap(BitLiteral, literals)), conjunction)
    compare(backend, rule, boundary, black_and_white(shape, seed)[0])


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
def test_neighbourhoods_on_wide_grids(backend: Backend, boundary: Boundary) -> None:
    rng = np.random.default_rng(10)
    for shape in WIDE:
        for size, conjunction in ((0, True), (1, False), (4, True), (9, False)):
            places = {(int(k), int(l)) for k, l in rng.integers(-5, 6, (size, 2))}
            rule = BitRule(tuple(BitLiteral(k, l, bool(rng.random() < 0.5)) for k, l in places), conjunction)
            compare(backend, rule, boundary, rng.random(shape) < (0.9 if conjunction else 0.1))


@pytest.mark.parametrize("shape", [(1, 4), (2, 2), (2, 1, 2)])
def test_the_output_is_clipped_and_keeps_nan(backend: Backend, shape: Any) -> None:
    x = backend.load(np.reshape([-3, -0.5, 2, np.nan], shape), "lam")
    y = np.reshape([-1, -0.5, 1, np.nan], shape)
    assert np.array_equal(backend.read(backend.output(x)), y, equal_nan=True)
    assert backend.read(x).flat[0] == -3
