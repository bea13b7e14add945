"""Templates from rules: margins at least those of the library, certificates, fits of coupled ones."""

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import fixed, library
from cnnsim.prototyping.design.decompose import separable_design
from cnnsim.prototyping.design.design import Design
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.fit import fit
from cnnsim.prototyping.design.linear import Certificate, Norm, Separator, separate
from cnnsim.prototyping.design.rule import WindowRule, windows
from cnnsim.prototyping.design.verify import wrong_windows
from cnnsim.transient import run_transient
from tests.kits.design import rule_of
from tests.oracles.pictures import plane
from tests.oracles.wholes import fill_holes
from tests.oracles.windows import RULES

LIBRARY = [name for name in RULES if (library.load(name).margin or 0) > 0]
"""Uncoupled templates of one picture, r <= 1; those with margin 0 have nothing to be compared with."""


def library_ratio(name: str, norm: Norm) -> float:
    """Margin of a library template over the sum (or the largest) of what enters its decision: |B|, |z|, and a - 1."""
    entry = library.load(name)
    remembered = abs(entry.template.self_feedback - 1) if entry.initial_state == "picture" else 0.0
    sizes = [*np.abs(entry.template.B).ravel(), abs(entry.template.z), remembered]
    assert entry.margin is not None
    return entry.margin / (sum(sizes) if norm == "sum" else max(sizes))


def test_enough_templates_are_compared() -> None:
    assert {"edge", "corner", "erosion-square", "dilation-square"} <= set(LIBRARY)
    assert len(LIBRARY) >= 24


@pytest.mark.parametrize(
    ("name", "norm"), [*((name, "sum") for name in LIBRARY), *((name, "largest") for name in LIBRARY[::5])]
)
def test_the_margin_is_at_least_that_of_the_library(name: str, norm: Norm) -> None:
    found = separable_design(rule_of(name), norm)
    assert isinstance(found, Design)
    part = found.parts[0]
    drives = part.separator.drive(found.rule.rows[:, :9])
    exact = min(d * int(wanted) for d, wanted in zip(drives, found.rule.table, strict=True))
    assert exact == 1
    assert part.separator.relative_margin(norm) >= library_ratio(name, norm) - 1e-12


@pytest.mark.parametrize("name", ["edge-no-feedback", "erosion-cross", "dilation-cross", "erosion-l-shape"])
def test_templates_on_a_tie_get_a_margin(name: str) -> None:
    found = separable_design(rule_of(name))
    assert isinstance(found, Design)
    assert found.relative_margin() > 0.05
    assert not wrong_windows(found, backend="reference")


@pytest.mark.parametrize("name", ["edge", "corner", "skeleton-2", "horizontal-skeleton-left", "life-layer-1"])
def test_designed_templates_run_right_on_all_windows(name: str) -> None:
    found = separable_design(rule_of(name))
    assert isinstance(found, Design)
    for backend in ("reference", "cpu"):
        assert wrong_windows(found, backend=backend) == []


def test_by_hand() -> None:
    """AND of two cells: w = 1, z = -1, margin 1 of 3; nothing is better, as the LP's dual says."""
    found = separate(windows(2), np.array([-1, -1, -1, 1], dtype=np.int8))
    assert found == Separator((Fraction(1), Fraction(1)), Fraction(-1))
    erosion = separable_design(parse_rule("all9 == 9"))
    assert isinstance(erosion, Design)
    assert erosion.parts[0].separator.weights == (Fraction(1),) * 9
    assert erosion.parts[0].separator.bias == -8


def test_weights_are_as_symmetric_as_the_rule() -> None:
    found = separable_design(parse_rule("c and ring8 < 8"))
    assert isinstance(found, Design)
    b = found.parts[0].template("edge").B
    assert np.array_equal(b, [[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]])


def test_what_the_rule_leaves_open_makes_the_margin_larger() -> None:
    whole = rule_of("edge")
    few = np.where(np.arange(512) % 5 == 0, whole.table, 0)
    found = separable_design(WindowRule(few))
    assert isinstance(found, Design)
    strict = separable_design(whole)
    assert isinstance(strict, Design)
    assert found.relative_margin() > strict.relative_margin()
    assert (found.answer()[few != 0] == few[few != 0]).all()


def test_a_random_table_has_a_threshold_or_a_certificate() -> None:
    found = Counter[type]()

    @settings(max_examples=25)
    @given(data=st.data())
    def check(data: st.DataObject) -> None:
        found[_checked(data)] += 1

    check()
    assert found[Certificate] >= 2
    assert found[Separator] >= 2


def _checked(data: st.DataObject) -> type:
    """Check the answer for a drawn table, and return its type."""
    size = data.draw(st.integers(1, 4))
    table = np.array(
        data.draw(st.lists(st.sampled_from([-1, 0, 1]), min_size=2**size, max_size=2**size)), dtype=np.int8
    )
    rows = windows(size)
    if not table.any():
        return type(None)
    found = separate(rows, table)
    if isinstance(found, Certificate):
        assert found.holds(rows, table)
        assert _no_threshold(rows, table)
    else:
        assert min(d * int(t) for d, t in zip(found.drive(rows), table, strict=True) if t) == 1
    return type(found)


def _no_threshold(rows: np.ndarray, table: np.ndarray) -> bool:
    """The perceptron, an independent search, finds none either."""
    weights = np.zeros(rows.shape[1] + 1)
    for _ in range(300):
        wrong = False
        for row, wanted in zip(rows.astype(int), table, strict=True):
            if wanted and wanted * (weights[:-1] @ row + weights[-1]) <= 0:
                weights += wanted * np.append(row, 1)
                wrong = True
        if not wrong:
            return False
    return True


def test_a_certificate_can_fail() -> None:
    rows, table = windows(2), np.array([-1, 1, 1, -1], dtype=np.int8)
    found = separate(rows, table)
    half = Fraction(1, 2)
    assert found == Certificate(((half, 1), (half, 2)), ((half, 0), (half, 3)))
    assert not Certificate(((half, 1), (half, 2)), ((Fraction(1), 0),)).holds(rows, table)
    assert not Certificate(((half, 0), (half, 3)), ((half, 1), (half, 2))).holds(rows, table)
    assert not Certificate(((half, 1),), ((half, 0),)).holds(rows, table)


def test_a_coupled_template_is_fitted_to_pairs() -> None:
    rng = np.random.default_rng(0)
    drawn = [rng.random((8, 9)) < share for share in (0.4, 0.6)]
    pairs = [(plane(p), plane(fill_holes(p))) for p in drawn]
    found = fit(pairs, fixed(-1), initial_state=1.0, seed=2, generations=40)
    assert found.wrong == 0
    assert not found.template.uncoupled
    assert np.array_equal(found.template.A, np.rot90(found.template.A))
    for picture, wanted in pairs:
        y = run_transient(found.template, state=np.ones(picture.shape), input=picture, boundary=fixed(-1)).y
        assert (y * wanted > 0.99).all()
    one, other = (fit(pairs, fixed(-1), initial_state=1.0, seed=2, generations=2) for _ in range(2))
    assert np.array_equal(one.template.A, other.template.A)
