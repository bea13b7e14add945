"""Packed planes and the templates that run on them, against plain booleans and against the templates' real numbers."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import library
from cnnsim.backends import get
from cnnsim.network.boundary import PERIODIC, ZERO_FLUX, Boundary, fixed
from cnnsim.network.template import Template
from cnnsim.operations.bitwise import BitLiteral, BitRule, bit_rule
from cnnsim.operations.logic import FUNCTIONS
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.transient import run_transient

CPU, REFERENCE = get("cpu"), get("reference")
BOUNDARIES = (fixed(-1), fixed(1), ZERO_FLUX, PERIODIC)
SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 200)) | st.tuples(
    st.integers(1, 3), st.integers(1, 5), st.integers(1, 70)
)


def planes(shape: tuple[int, ...], seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.random(shape) > 0.4, rng.random(shape) > 0.6]


@settings(max_examples=60)
@given(SHAPES, st.integers(0, 99))
def test_packing_logic_and_counting(shape: tuple[int, ...], seed: int) -> None:
    p, q = planes(shape, seed)
    packed = CPU.load(p, "llm"), CPU.load(q, "llm")
    np.testing.assert_array_equal(CPU.read(packed[0]), p)
    np.testing.assert_array_equal(CPU.read(CPU.convert(packed[0], "lam")), np.where(p, 1, -1))
    np.testing.assert_array_equal(CPU.read(CPU.convert(CPU.load(np.where(p, 0.1, 0.0), "lam"), "llm")), p)
    for function in range(len(FUNCTIONS)):
        got, want = CPU.logic(function, *packed), REFERENCE.logic(function, p, q)
        np.testing.assert_array_equal(CPU.read(got), want)
        np.testing.assert_array_equal(CPU.count(got), REFERENCE.count(want))  # no stray bits beyond the last column


@settings(max_examples=100)
@given(
    SHAPES,
    st.sampled_from(BOUNDARIES),
    st.lists(st.tuples(st.integers(-5, 5), st.integers(-5, 5), st.booleans()), max_size=6),
    st.booleans(),
    st.integers(0, 99),
)
def test_neighbourhoods(
    shape: tuple[int, ...], boundary: Boundary, literals: list[tuple[int, int, bool]], every: bool, seed: int
) -> None:
    rule = BitRule(tuple(itertools.starmap(BitLiteral, literals)), every)
    p = planes(shape, seed)[0]
    got, want = CPU.neighbourhood(rule, boundary, CPU.load(p, "llm")), REFERENCE.neighbourhood(rule, boundary, p)
    np.testing.assert_array_equal(CPU.read(got), want)
    np.testing.assert_array_equal(CPU.count(got), REFERENCE.count(want))


def rule_of(name: str) -> BitRule | None:
    entry = library.load(name)
    state = {"picture": None, "any": 0.0}.get(str(entry.initial_state), entry.initial_state)
    return bit_rule(entry.template, entry.boundary, state)  # type: ignore[arg-type]  # numbers are left


@pytest.mark.parametrize("name", library.names("uncoupled"))
def test_a_rule_does_what_the_template_does(name: str) -> None:
    entry = library.load(name)
    if entry.initial_state == "given" or entry.input != "picture" or (rule := rule_of(name)) is None:
        pytest.skip("no AND or OR of one picture's cells")
    for boundary in (entry.boundary, *BOUNDARIES):
        p = planes((40, 150), 5)[0]
        task = entry.planes(np.where(p, 1.0, -1.0))
        want = run_transient(entry.template, **task, boundary=boundary, backend="reference").x > 0
        np.testing.assert_array_equal(REFERENCE.neighbourhood(rule, boundary, p), want)
        np.testing.assert_array_equal(CPU.read(CPU.neighbourhood(rule, boundary, CPU.load(p, "llm"))), want)


@pytest.mark.parametrize("name", ["erosion-square", "dilation-cross", "shift-ne", "logic-not", "point-extraction"])
def test_the_morphology_of_the_library_is_found(name: str) -> None:
    assert rule_of(name) is not None


def test_what_is_no_rule() -> None:
    ones = np.ones((3, 3))
    assert bit_rule(Template(1, ones), ZERO_FLUX, 0.0) is None  # a majority
    assert bit_rule(Template(1, ones, -8), fixed(0), 0.0) is None  # virtual cells neither black nor white
    assert bit_rule(Template(1, ones, -9), ZERO_FLUX, 0.0) is None  # the answer hangs on a tie
    assert bit_rule(Template([[0, 1, 0], [0, 2, 0], [0, 0, 0]], 1), ZERO_FLUX, 0.0) is None  # coupled
    assert bit_rule(Template(1, ones, -8), ZERO_FLUX, 0.0) == BitRule(
        tuple(BitLiteral(k, l, False) for k in (-1, 0, 1) for l in (-1, 0, 1)), True
    )


def test_a_program_on_a_batch_is_the_program_on_each_grid() -> None:
    program = load_program("opening")
    pictures = np.where(planes((6, 30, 80), 2)[0], 1.0, -1.0)
    for backend in (CPU, REFERENCE):
        name = program.inputs[0]
        batch = UniversalMachine(backend).run(program, **{name: pictures})
        for i, picture in enumerate(pictures):
            alone = UniversalMachine(backend).run(program, **{name: picture})
            for output, value in alone.items():
                np.testing.assert_array_equal(batch[output][i], value)
