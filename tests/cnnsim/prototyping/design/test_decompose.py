"""Rules that take several templates: decompositions run on all windows and on whole pictures."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim import InputError, fixed, library
from cnnsim.program.file import load_program
from cnnsim.prototyping.design.decompose import design_rule
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.files import write_design
from cnnsim.prototyping.design.rule import WindowRule, windows
from cnnsim.prototyping.design.verify import run_program, wrong_windows
from tests.oracles.pictures import plane

HARD = {
    "c xor n": 2,
    "ring4 == 2": 2,
    "(n + c + s) % 2 == 1": 2,
    "ring4 % 2 == 1": 3,
    "all9 % 2 == 1": 5,
    "all9 % 4 == 2": 3,
    "ring8 == 3 or c and ring8 == 2": 2,
    "(n and e) or (s and w)": 2,
    "c and (n xor s)": 2,
    "c == x": 2,
    "(n and not s) or (e and not w) or (nw and not se)": 4,
}
"""Rules that no single template can do, and the most templates they may take."""


@pytest.mark.parametrize(("text", "most"), HARD.items())
def test_hard_rules_are_decomposed_and_run_right_on_all_windows(text: str, most: int, tmp_path: Path) -> None:
    rule = parse_rule(text)
    found = design_rule(rule)
    assert found.certificate is not None
    assert found.certificate.holds(rule.rows, rule.table)
    assert 2 <= len(found.parts) <= most
    assert np.array_equal(found.answer(), rule.table)
    paths = write_design(found, "hard", fixed(-1), tmp_path)
    for backend in ("reference", "cpu"):
        assert wrong_windows(found, paths[-1], backend) == []
    for path in paths[:-1]:
        entry = library.load_file(path)
        for example in entry.examples:
            assert example.holds(library.run_example(entry, example).y)


def test_parity_on_whole_pictures_is_that_of_a_sum(tmp_path: Path) -> None:
    found = design_rule(parse_rule("all9 % 2 == 1"))
    program = load_program(write_design(found, "parity", fixed(-1), tmp_path)[-1])
    rng = np.random.default_rng(0)
    for shape in ((1, 1), (1, 7), (13, 9)):
        black = rng.random(shape) < 0.5
        around = np.pad(black, 1).astype(int)
        total = sum(around[k : k + shape[0], l : l + shape[1]] for k in range(3) for l in range(3))
        assert np.array_equal(run_program(program, plane(black), None) > 0, total % 2 == 1)


def test_a_state_that_turns_a_rule_takes_one_template_more() -> None:
    found = design_rule(parse_rule("(ring8 % 2 == 1) xor x"))
    assert len(found.parts) == 6
    assert np.array_equal(found.answer(), found.rule.table)


def test_more_templates_than_allowed_are_asked_for() -> None:
    rule = parse_rule("(n + e + s + w) % 2 == 1 and x")
    with pytest.raises(
        InputError, match=r"no design of at most 2 templates found; .* more templates \(--most\), wanted"
    ):
        design_rule(rule, most=2)
    assert len(design_rule(rule).parts) > 2


@pytest.mark.parametrize("seed", range(4))
def test_random_rules_of_four_cells(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    answers = rng.choice([-1, 1], 16)
    rows = windows(9) > 0
    rule = WindowRule(answers[rows[:, [1, 4, 5, 7]] @ np.array([8, 4, 2, 1])])
    found = design_rule(rule)
    paths = write_design(found, "random", fixed(-1), tmp_path)
    assert wrong_windows(found, None if found.one_template else paths[-1], "reference") == []


def test_a_negative_weight_of_the_initial_state_turns_it_first(tmp_path: Path) -> None:
    found = design_rule(parse_rule("c and not x"))
    assert len(found.parts) == 1
    assert not found.one_template
    assert wrong_windows(found, write_design(found, "fresh", fixed(-1), tmp_path)[-1]) == []
    kept = design_rule(parse_rule("c and x"))
    assert kept.one_template
    assert kept.parts[0].template("and").self_feedback == 2
