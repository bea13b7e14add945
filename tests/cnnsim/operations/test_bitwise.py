"""Templates that run on packed planes: their rules against their real numbers, and what is no rule."""

import numpy as np
import pytest

from cnnsim import library
from cnnsim.backends import get
from cnnsim.network import PERIODIC, ZERO_FLUX, Template, fixed
from cnnsim.operations.bitwise import BitLiteral, BitRule, bit_rule
from cnnsim.transient import run_transient

CPU, REFERENCE = get("cpu"), get("reference")


BOUNDARIES = (fixed(-1), fixed(1), ZERO_FLUX, PERIODIC)


def planes(shape: tuple[int, ...], seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.random(shape) > 0.4, rng.random(shape) > 0.6]


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
