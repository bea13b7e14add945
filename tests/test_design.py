"""Design from rules: margins at least those of the library, certificates, decompositions run on all windows, fits."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import fixed, library, write_picture
from cnnsim.cli_prototyping import design as design_command
from cnnsim.errors import InputError
from cnnsim.machine import UniversalMachine
from cnnsim.program_file import load_program
from cnnsim.prototyping.design import Design, design, single
from cnnsim.prototyping.expression import parse_rule
from cnnsim.prototyping.files import write_design
from cnnsim.prototyping.fit import fit
from cnnsim.prototyping.linear import Certificate, Norm, Separator, separate
from cnnsim.prototyping.rule import NAMES, Rule, windows
from cnnsim.prototyping.rule_files import read_table, rule_of_pairs
from cnnsim.prototyping.verify import run_program, wrong_windows
from cnnsim.transient import run_transient
from tests.oracles.pictures import plane
from tests.oracles.wholes import fill_holes
from tests.oracles.windows import RULES, Window

LIBRARY = [name for name in RULES if (library.load(name).margin or 0) > 0]
"""Uncoupled templates of one picture, r <= 1; those with margin 0 have nothing to be compared with."""


def rule_of(name: str) -> Rule:
    """The rule of a library template, from its task in words and not from its numbers."""
    rows = (windows(9) > 0).reshape(512, 3, 3)
    cells = Window(*(rows[:, i, j] for i in range(3) for j in range(3)))
    return Rule(np.where(np.asarray(RULES[name](cells), dtype=bool), 1, -1), name)


def library_ratio(name: str, norm: Norm) -> float:
    """Margin of a library template over the sum (or the largest) of what enters its decision: |B|, |z|, and a - 1."""
    entry = library.load(name)
    remembered = abs(entry.template.self_feedback - 1) if entry.initial_state == "picture" else 0.0
    sizes = [*np.abs(entry.template.B).ravel(), abs(entry.template.z), remembered]
    assert entry.margin is not None
    return entry.margin / (sum(sizes) if norm == "sum" else max(sizes))


# --- one template -----------------------------------------------------------------------------------------------


def test_enough_templates_are_compared() -> None:
    assert {"edge", "corner", "erosion-square", "dilation-square"} <= set(LIBRARY)
    assert len(LIBRARY) >= 24


@pytest.mark.parametrize("norm", ["sum", "largest"])
@pytest.mark.parametrize("name", LIBRARY)
def test_the_margin_is_at_least_that_of_the_library(name: str, norm: Norm) -> None:
    found = single(rule_of(name), norm)
    assert isinstance(found, Design)
    part = found.parts[0]
    drives = part.separator.drive(found.rule.rows[:, :9])
    exact = min(d * int(wanted) for d, wanted in zip(drives, found.rule.table, strict=True))
    assert exact == 1
    assert part.separator.relative_margin(norm) >= library_ratio(name, norm) - 1e-12


@pytest.mark.parametrize("name", ["edge-no-feedback", "erosion-cross", "dilation-cross", "erosion-l-shape"])
def test_templates_on_a_tie_get_a_margin(name: str) -> None:
    found = single(rule_of(name))
    assert isinstance(found, Design)
    assert found.relative_margin() > 0.05
    assert not wrong_windows(found, backend="reference")


@pytest.mark.parametrize("name", ["edge", "corner", "skeleton-2", "horizontal-skeleton-left", "life-layer-1"])
def test_designed_templates_run_right_on_all_windows(name: str) -> None:
    found = single(rule_of(name))
    assert isinstance(found, Design)
    for backend in ("reference", "cpu"):
        assert wrong_windows(found, backend=backend) == []


def test_by_hand() -> None:
    """AND of two cells: w = 1, z = -1, margin 1 of 3; nothing is better, as the LP's dual says."""
    found = separate(windows(2), np.array([-1, -1, -1, 1], dtype=np.int8))
    assert found == Separator((Fraction(1), Fraction(1)), Fraction(-1))
    erosion = single(parse_rule("all9 == 9"))
    assert isinstance(erosion, Design)
    assert erosion.parts[0].separator.weights == (Fraction(1),) * 9
    assert erosion.parts[0].separator.bias == -8


def test_weights_are_as_symmetric_as_the_rule() -> None:
    found = single(parse_rule("c and ring8 < 8"))
    assert isinstance(found, Design)
    b = found.parts[0].template("edge").B
    assert np.array_equal(b, [[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]])


def test_what_the_rule_leaves_open_makes_the_margin_larger() -> None:
    whole = rule_of("edge")
    few = np.where(np.arange(512) % 5 == 0, whole.table, 0)
    found = single(Rule(few))
    assert isinstance(found, Design)
    strict = single(whole)
    assert isinstance(strict, Design)
    assert found.relative_margin() > strict.relative_margin()
    assert (found.answer()[few != 0] == few[few != 0]).all()


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_a_random_table_has_a_threshold_or_a_certificate(data: st.DataObject) -> None:
    size = data.draw(st.integers(1, 4))
    table = np.array(
        data.draw(st.lists(st.sampled_from([-1, 0, 1]), min_size=2**size, max_size=2**size)), dtype=np.int8
    )
    rows = windows(size)
    if not table.any():
        return
    found = separate(rows, table)
    if isinstance(found, Certificate):
        assert found.holds(rows, table)
        assert _no_threshold(rows, table)
    else:
        assert min(d * int(t) for d, t in zip(found.drive(rows), table, strict=True) if t) == 1


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


# --- several templates ------------------------------------------------------------------------------------------

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
    found = design(rule)
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
    found = design(parse_rule("all9 % 2 == 1"))
    program = load_program(write_design(found, "parity", fixed(-1), tmp_path)[-1])
    rng = np.random.default_rng(0)
    for shape in ((1, 1), (1, 7), (13, 9)):
        black = rng.random(shape) < 0.5
        around = np.pad(black, 1).astype(int)
        total = sum(around[k : k + shape[0], l : l + shape[1]] for k in range(3) for l in range(3))
        assert np.array_equal(run_program(program, plane(black), None) > 0, total % 2 == 1)


@pytest.mark.parametrize("seed", range(4))
def test_random_rules_of_four_cells(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    answers = rng.choice([-1, 1], 16)
    rows = windows(9) > 0
    rule = Rule(answers[rows[:, [1, 4, 5, 7]] @ np.array([8, 4, 2, 1])])
    found = design(rule)
    paths = write_design(found, "random", fixed(-1), tmp_path)
    assert wrong_windows(found, None if found.single else paths[-1], "reference") == []


def test_a_negative_weight_of_the_initial_state_turns_it_first(tmp_path: Path) -> None:
    found = design(parse_rule("c and not x"))
    assert len(found.parts) == 1
    assert not found.single
    assert wrong_windows(found, write_design(found, "fresh", fixed(-1), tmp_path)[-1]) == []
    kept = design(parse_rule("c and x"))
    assert kept.single
    assert kept.parts[0].template("and").self_feedback == 2


# --- rules ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["edge", "corner", "junction", "life-layer-2", "erosion-cross", "dead-end-filler"])
def test_expressions_of_library_rules(name: str) -> None:
    text = {
        "edge": "c and not (ring8 == 8)",
        "corner": "c and 8 - ring8 >= 5",
        "junction": "c and ring8 >= 3",
        "life-layer-2": "2 >= all9",
        "erosion-cross": "c and n and e and s and w",
        "dead-end-filler": "c or n + e + s + w > 2",
    }[name]
    assert np.array_equal(parse_rule(text).table, rule_of(name).table)


def test_precedence_is_that_of_python() -> None:
    """Python's own operators on every window are the oracle."""
    for text in (
        "not n and c or s", "n or c and not s", "n + c * 2 - s > 1", "0 <= n - s < 1", "not n == c",
        "(n + c) % 2 == 1 and e",
        "n < c == s", "-n + 1 == c", "not not n", "n * c != e", "n - c - s >= -1", "2 * -n < 0",
    ):  # fmt: skip
        table = parse_rule(text).table
        for code in (0, 17, 146, 200, 255, 311, 511):
            cells = {name: code >> (8 - i) & 1 for i, name in enumerate(NAMES[:9])}
            assert table[code] == (1 if eval(text, {"__builtins__": {}}, cells) else -1), (text, code)
    assert np.array_equal(parse_rule("n xor c and s").table, parse_rule("n xor (c and s)").table)
    assert np.array_equal(parse_rule("n or c xor s").table, parse_rule("n or (c xor s)").table)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("c andd n", "'andd' at character 3"),
        ("c and", "the end"),
        ("c and q", "'q' at character 7"),
        ("(c", r"'\)' wanted"),
        ("c n", "'n' at character 3"),
        ("__import__('os')", "__import__"),
        ("c % 0", "division by 0"),
        ("c ** 2", "character 4"),
        ("9999999999 > c", "a number below"),
        ("99999999 * 99999999 > c", "beyond"),
        ("(" * 200 + "c" + ")" * 200, "deep"),
        ("c;n", "';'"),
        ("", "the end"),
    ],
)
def test_a_wrong_expression(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_rule(text)


def test_a_truth_table_file(tmp_path: Path) -> None:
    file = tmp_path / "rule.toml"
    file.write_text('default = "white"\nblack = [["?.?", "?#?", "???"], ["?#?", "?.?", "???"]]\n')
    assert np.array_equal(read_table(file).table, parse_rule("c xor n").table)
    file.write_text('black = [["???", "?#?", "???", "."]]\nwhite = [["???", "???", "???", "#"]]\n')
    rule = read_table(file)
    assert rule.with_state
    assert (rule.table == 0).sum() == 256


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('black = [["###", "###", "###"]]\nwhite = [["?#?", "???", "???"]]', "###/###/### is said to be black and"),
        ('black = [["##", "###", "###"]]', "three strings"),
        ('black = [["##x", "###", "###"]]', "holds 'x'"),
        ("blak = []", "unknown key 'blak'"),
        ('default = "red"', "default is 'red'"),
        ("black = []", "no window"),
        ("black = [", "no TOML"),
    ],
)
def test_a_wrong_truth_table(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "rule.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_table(tmp_path / "rule.toml")


def test_pairs_of_pictures_give_the_windows_that_occur() -> None:
    rng = np.random.default_rng(1)
    pairs = []
    for _ in range(3):
        picture = plane(rng.random((20, 20)) < 0.5)
        pairs.append((picture, library.run("edge", picture).y))
    rule = rule_of_pairs(pairs, fixed(-1))
    known = rule.table != 0
    assert 200 < known.sum() < 512
    assert np.array_equal(rule.table[known], rule_of("edge").table[known])
    assert single(rule)


def test_a_contradiction_is_named_with_its_places() -> None:
    picture = np.full((3, 4), -1.0)
    wanted = picture.copy()
    wanted[1, 2] = 1.0
    with pytest.raises(
        InputError, match=r"\.\.\./\.\.\./\.\.\. becomes white in pair 1, cell 0,0 and black in pair 1, cell 1,2"
    ):
        rule_of_pairs([(picture, wanted)], fixed(-1))


# --- coupled templates ------------------------------------------------------------------------------------------


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
    again = fit(pairs, fixed(-1), initial_state=1.0, seed=2, generations=40)
    assert np.array_equal(again.template.A, found.template.A)


# --- the command ------------------------------------------------------------------------------------------------


def run(*arguments: str) -> Any:
    return CliRunner().invoke(design_command, list(arguments))


def test_the_command_writes_a_template_that_the_library_reads(tmp_path: Path) -> None:
    result = run("--rule", "c and ring8 < 8", "--name", "my-edge", "-o", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "checked   all 512 windows" in result.output
    entry = library.load_file(tmp_path / "my-edge.toml")
    assert len(entry.examples) == 2
    assert all(example.holds(library.run_example(entry, example).y) for example in entry.examples)


def test_the_command_writes_a_program(tmp_path: Path) -> None:
    result = run("--rule", "c xor x", "--name", "differs", "-o", str(tmp_path), "--json")
    data = json.loads(result.output)
    assert not data["single"]
    assert data["certificate"]["black"][0]["share"] == "1/2"
    program = load_program(tmp_path / "programs" / "differs.toml")
    picture, state = plane(np.array([[0, 0, 1, 1]]) > 0), plane(np.array([[0, 1, 0, 1]]) > 0)
    out = UniversalMachine().run(program, picture=picture, state=state)["result"]
    assert (out > 0).tolist() == [[False, True, True, False]]


def test_the_command_on_pairs_of_pictures(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    drawn = rng.random((8, 9)) < 0.5
    write_picture(plane(drawn), tmp_path / "in.png")
    write_picture(library.run("corner", plane(drawn)).y, tmp_path / "out.png")
    write_picture(plane(fill_holes(drawn)), tmp_path / "filled.png")
    pair = f"{tmp_path / 'in.png'}={tmp_path / 'out.png'}"
    assert "are open" in run("--pair", pair, "--name", "learned", "-o", str(tmp_path)).output
    entry = library.load_file(tmp_path / "learned.toml")
    shown = entry.examples[0].input
    assert shown is not None
    assert np.array_equal(shown, plane(drawn))
    pair = f"{tmp_path / 'in.png'}={tmp_path / 'filled.png'}"
    result = run("--pair", pair, "--coupled", "--state", "1", "--name", "filled", "-o", str(tmp_path))
    assert result.exit_code == 0, result.exception
    assert library.load_file(tmp_path / "filled.toml").initial_state == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["--name", "x"],
        ["--rule", "c", "--table", "t.toml", "--name", "x"],
        ["--rule", "c", "--name", "Bad Name"],
        ["--rule", "c", "--name", "x", "--coupled"],
        ["--pair", "one.png", "--name", "x"],
        ["--pair", "a=b", "--name", "x"],
    ],
)
def test_mistakes(arguments: list[str], tmp_path: Path) -> None:
    assert isinstance(run(*arguments, "-o", str(tmp_path)).exception, InputError)
