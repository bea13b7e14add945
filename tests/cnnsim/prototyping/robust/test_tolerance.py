"""Margins and tolerated errors against their definitions, cell by cell."""

import itertools

import numpy as np
import pytest

from cnnsim import library
from cnnsim.network.cell import output, uncoupled_state
from cnnsim.prototyping.robust.error_rate import final_colour
from cnnsim.prototyping.robust.margin import margin_of, tolerated_error

WITH_MARGIN = [name for name in library.names("binary") if library.load(name).margin is not None]
UNCOUPLED = [name for name in WITH_MARGIN if library.load(name).template.uncoupled]


def test_the_margin_is_that_of_the_file() -> None:
    for entry in map(library.load, WITH_MARGIN):
        found = margin_of(entry)
        assert found.value == pytest.approx(entry.margin, abs=1e-9), entry.name
        assert found.exact is entry.template.uncoupled, entry.name


@pytest.mark.parametrize("name", ["muller-lyer", "approximate-diagonal-detector"])
def test_a_tie_leaves_nothing_to_spare(name: str) -> None:
    """Six black neighbours of 24 tie in muller-lyer: 1.3 + 0.1 (18 - 6) - 2.8 + 0.3 = 0, but for rounding."""
    found = margin_of(library.load(name))
    assert (found.value, found.tolerated) == (0.0, 0.0)


@pytest.mark.parametrize(
    "name", ["average", "diffusion", "halftone-5x5", "poisson-solver", "median", "autowave", "discrete-edge"]
)
def test_a_margin_does_not_apply_to_grey_templates(name: str) -> None:
    found = margin_of(library.load(name))
    assert found.value is None
    assert found.tolerated is None
    assert "does not apply" in found.why


def test_a_grey_template_that_decides_is_not_said_to_decide_nothing() -> None:
    assert "how near a cell is to its decision" in margin_of(library.load("threshold")).why
    assert "decides nothing" in margin_of(library.load("average")).why


def colours(name: str, factors: dict[tuple[int, ...], float], epsilon: float) -> np.ndarray:
    """Colours in the end, from the closed form of the cell, of all neighbourhoods with entries times 1 + epsilon f."""
    entry = library.load(name)
    b = entry.template.B * (1 + epsilon * np.array([factors[1, i] for i in range(entry.template.B.size)]).reshape(
        entry.template.B.shape))  # fmt: skip
    z = entry.template.z * (1 + epsilon * factors[2,])
    a = entry.template.self_feedback * (1 + epsilon * factors[0,])
    count = 2 ** (b.size + 1)
    rows = 2.0 * (np.arange(count)[:, None] >> np.arange(b.size + 1) & 1) - 1
    u, other = rows[:, :-1], rows[:, -1]
    s = u @ b.ravel() + z
    if isinstance(entry.initial_state, int | float):
        x0 = np.full(count, float(entry.initial_state))
    else:
        assert isinstance(entry.initial_state, str)
        x0 = {"picture": u[:, b.size // 2], "given": other, "any": other}[entry.initial_state]
    with np.errstate(all="ignore"):
        return np.sign(np.round(output(uncoupled_state(x0, s, a, 400.0, "chua-yang")), 12))


@pytest.mark.parametrize("name", UNCOUPLED)
def test_the_tolerated_error_is_exact(name: str) -> None:
    """Just below it every corner of the box of errors leaves all cells right; just above it some corner does not."""
    entry = library.load(name)
    found = margin_of(entry).tolerated
    assert found is not None
    if found == 0:
        assert np.isclose(library.load(name).margin or 0, 0)
        return
    size = entry.template.B.size
    keys: list[tuple[int, ...]] = [(0,), (2,), *((1, i) for i in range(size))]
    right = colours(name, dict.fromkeys(keys, 0.0), 0.0)
    if entry.initial_state == "any":  # the colour of x(0) = anything is that of the drive
        assert np.array_equal(right[: len(right) // 2], right[len(right) // 2 :])
    rng = np.random.default_rng(1)
    corners = [dict.fromkeys(keys, 1.0), dict.fromkeys(keys, -1.0)]
    corners += [dict(zip(keys, rng.choice([-1.0, 1.0], len(keys)), strict=True)) for _ in range(20)]
    b, z = entry.template.B.ravel(), entry.template.z
    count = np.arange(2**size)
    u = 2.0 * (count[:, None] >> np.arange(size) & 1) - 1
    weakest = np.argsort(
        np.abs(u @ b + z + (entry.template.self_feedback - 1) * (entry.initial_state == "picture") * u[:, size // 2])
    )
    for row, push, a_error in itertools.product(u[weakest[:200]], (-1.0, 1.0), (-1.0, 1.0)):
        terms = push * np.sign(b * row)
        corners.append({(0,): a_error, (2,): push * float(np.sign(z)), **{(1, i): terms[i] for i in range(size)}})
    below = [np.array_equal(colours(name, corner, 0.999 * found), right) for corner in corners[:60]]
    assert all(below)
    assert any(not np.array_equal(colours(name, corner, 1.001 * found), right) for corner in corners)


def test_the_tolerated_error_by_hand() -> None:
    """EDGE: margin 1, sum of terms 17, and the self-feedback of 1 may err as well: 1 / 18."""
    assert margin_of(library.load("edge")).tolerated == pytest.approx(1 / 18)
    one = np.array([1.0])
    assert tolerated_error(one, np.array([0.0]), 2.0, 10.0)[0] == pytest.approx(1 / 10)
    assert tolerated_error(one, None, 0.0, 4.0)[0] == pytest.approx(1 / 4)
    assert tolerated_error(one, -one, 1.5, 4.0)[0] == pytest.approx(0.5 / 5.5)
    assert tolerated_error(one, one, 1.5, 40.0)[0] == pytest.approx(1.5 / 41.5)
    assert tolerated_error(one, one, 1.5, 4.0)[0] == pytest.approx(1.5 / 5.5)
    assert tolerated_error(one, one, 1.1, 2.0)[0] == pytest.approx(0.5)  # a falls below 1 before: s alone decides


def test_decisions_in_closed_form_are_those_of_the_cell() -> None:
    rng = np.random.default_rng(2)
    for a in (-0.5, 0.0, 0.9, 1.0, 1.3, 3.0):
        s, x0 = rng.uniform(-3, 3, 500), rng.uniform(-1, 1, 500)
        assert np.array_equal(final_colour(s, x0, a), np.sign(uncoupled_state(x0, s, a, np.inf, "chua-yang")))
