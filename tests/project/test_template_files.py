"""The pages on template and program files describe all keys, no others, and their examples run."""

import re
import tomllib
from pathlib import Path
from typing import Any, get_args

import pytest

from cnnsim import InputError, library, load_program
from cnnsim.network import CellModel
from cnnsim.network.characteristic import parse_cell
from cnnsim.operations.cellwise import BUILT_IN
from cnnsim.operations.global_wire import Wire
from cnnsim.operations.logic import FUNCTIONS
from cnnsim.program.program import ARITHMETIC
from tests.kits.paths import FILE_PAGES

PAGE = "\n".join(page.read_text(encoding="utf-8") for page in FILE_PAGES[:2])
FILES = {tomllib.loads(text)["name"]: text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)}
TEMPLATE = """
name = "x"
summary = "x"
reference = "x"
input = "picture"
initial_state = "any"
boundary = "zero-flux"
duration = 1
"""
PLAIN = TEMPLATE + "A = [[1]]\nz = 0\n"
PROGRAM = 'name = "x"\ninputs = ["a"]\noutputs = ["a"]\nllm = ["a"]\nwire = ["w"]\n'
VALUES = {"fill": "1", "repeat": "1", "until_unchanged": '"a"', "when": '"w"'}


def _keys(heading: str) -> set[str]:
    """The keys in the first column of the table under a heading (or other line that begins so)."""
    (after,) = re.findall(rf"^{re.escape(heading)}\n(.*?)(?=^#|\Z)", PAGE, re.DOTALL | re.MULTILINE)
    table = re.search(r"^\| key .*?\n\n", after + "\n", re.DOTALL | re.MULTILINE)
    assert table is not None
    return {key for row in table[0].strip().splitlines() for key in re.findall(r"`(\w+)`", row.split("|")[1])}


def _refused(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_program(path) if "inputs" in text else library.load_file(path)
    return str(error.value)


def _known(message: str) -> set[str]:
    """The keys that a reader names when it meets one that it does not know."""
    return set(re.findall(r"known are (.*?)(?:;|$)", message)[0].split(", "))


@pytest.mark.parametrize(
    ("heading", "text"),
    [
        ("## A template", PLAIN + '"%" = 1'),
        ("### Terms", PLAIN + '[[term]]\n"%" = 1'),
        ("### Layers", TEMPLATE + '[[layer]]\n"%" = 1'),
        ("### Examples", PLAIN + '[[example]]\n"%" = 1'),
        ("# Program files", '"%" = 1\ninputs = []'),
        ("Templates defined in the program:", PROGRAM + '[templates.t]\n"%" = 1\n[[step]]\nfill = 1'),
    ],
)
def test_every_key_is_described_and_no_other(heading: str, text: str, tmp_path: Path) -> None:
    assert _keys(heading) == _known(_refused(tmp_path / "x.toml", text))


def test_every_key_of_a_cell_is_described() -> None:
    with pytest.raises(InputError) as error:
        parse_cell({"%": 1})
    assert _keys("### Cells") == set(re.findall(r"\w+", str(error.value).split(";")[1])) - {"wanted"}


def test_every_step_is_described_with_its_keys(tmp_path: Path) -> None:
    message = _refused(tmp_path / "x.toml", PROGRAM + '[[step]]\n"%" = 1')
    kinds = re.findall(r"none of (.*); exactly one", message)[0].split(", ")
    rows = [row.split("|") for row in PAGE.splitlines() if re.match(r"\| `\w+` \| .* \| `(to|of|do)`", row)]
    told = {re.findall(r"`(\w+)`", row[1])[0]: re.findall(r"`(\w+)`", row[3] + row[4]) for row in rows}
    assert list(told) == kinds
    for kind in kinds:
        step = f'[[step]]\n{kind} = {VALUES.get(kind, chr(34) + "a" + chr(34))}\n"%" = 1'
        assert {kind, *told[kind]} == _known(_refused(tmp_path / "x.toml", PROGRAM + step)), kind


WORDS = (
    *FUNCTIONS, *BUILT_IN, *ARITHMETIC, *get_args(Wire), *get_args(CellModel), "clip", "sign", "tanh", "zero-flux",
    "periodic", "settled", "picture", "given", "none", "any",
)  # fmt: skip


def test_every_word_that_a_value_can_be_is_named() -> None:
    assert [word for word in WORDS if f"`{word}`" not in PAGE and f'`"{word}"`' not in PAGE] == []


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("name", [name for name, text in FILES.items() if "[[example]]" in text])
def test_a_template_on_the_page_holds(name: str, folder: Path) -> None:
    entry = library.load_file(folder / f"{name}.toml")
    assert entry.examples
    for example in entry.examples:
        assert example.holds(library.run_example(entry, example).y)


def test_the_programs_on_the_page_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code, "templates/programs/README.md", "exec"), names)
    assert names["result"]["rounds"] == 3
