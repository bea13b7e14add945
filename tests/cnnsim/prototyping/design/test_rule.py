"""Rules in expressions, truth tables and pairs of pictures: what they mean and what is wrong with them."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim import fixed, library
from cnnsim.prototyping.design.decompose import separable_design
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.rule import NAMES
from cnnsim.prototyping.design.rule_files import read_table, rule_of_pairs
from cnnsim.support import InputError
from tests.kits.design import rule_of
from tests.oracles.pictures import plane


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
        (
            'black = [["###", "###", "###"]]\nwhite = [["?#?", "???", "???"]]',
            "###/###/### is in both lists, black",
        ),
        ('black = [["##", "###", "###"]]', "three strings"),
        ('black = [["##x", "###", "###"]]', "holds 'x'"),
        ("blak = []", "unknown key 'blak'"),
        ('default = "red"', "default is 'red'"),
        ("black = []", "no window"),
        ("black = [", "not TOML"),
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
    assert separable_design(rule)


def test_a_contradiction_is_named_with_its_places() -> None:
    picture = np.full((3, 4), -1.0)
    wanted = picture.copy()
    wanted[1, 2] = 1.0
    with pytest.raises(
        InputError, match=r"\.\.\./\.\.\./\.\.\. becomes white in pair 1, cell 0,0 and black in pair 1, cell 1,2"
    ):
        rule_of_pairs([(picture, wanted)], fixed(-1))
