"""Output of ``tactile run``: tables of events at any width, and JSON."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from tactile.cli.group import main
from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected, ProgramOutput
from tactile.output.json_data import run_data
from tactile.output.record import text_cell
from tactile.output.tables import tables
from tactile.settings import Settings
from tests.kits.paths import SCENES

GRIP = SCENES / "grip.toml"


def test_a_run_prints_one_table_and_json_alone() -> None:
    shown = CliRunner().invoke(main, ["run", str(GRIP)])
    assert shown.exit_code == 0
    lines = shown.stdout.splitlines()
    assert lines[0].startswith("Events")
    assert "time [s]" in lines[2]
    assert max(map(len, lines)) <= 150
    assert sum("slip +y" in line for line in lines) == 2
    assert all(line.startswith("│") == line.endswith("│") for line in lines)  # no cell is wrapped
    assert not any(line.startswith("│          │") for line in lines)
    assert not shown.stderr
    plain = CliRunner().invoke(main, ["run", str(GRIP), "--json"])
    assert json.loads(plain.stdout)["frames"] == 2400
    assert not plain.stderr


@pytest.mark.parametrize(
    ("side", "code", "hand"), [(2, True, True), (4, True, True), (5, False, True), (8, False, False)]
)
def test_codes_of_large_arrays_are_not_in_the_table(
    side: int, code: bool, hand: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    array = TaxelArray("pad", side, side, 1e-3, 1e-3)
    load = Load(1e-3, -2e-3, -1e-17, 2e-4, 4.2e-3, taxels=1, validity=Validity.INSIDE)
    event = Event(1.0, "pad", 3, "release", {}, "release", "·" * side, "0" * side, 0, 1e-4, load)
    collected = Collected()
    collected.take([event], [])
    tables(collected, (array,))
    heading, row = capsys.readouterr().out.splitlines()[2:5:2]
    assert ("code" in heading, "hand" in heading) == (code, hand)
    assert "(+1.00, -2.00) +0.000 +0.000 +0.004, inside, 1 taxel " in row


def test_an_unknown_force_is_a_question_mark(capsys: pytest.CaptureFixture[str]) -> None:
    load = Load(1e-3, 0.0, 0.15, float("nan"), 0.4, taxels=2, validity=Validity.INSIDE)
    collected = Collected()
    collected.take([Event(1.0, "row", 3, "release", {}, "release", "···", "000", 0, 1e-4, load)], [])
    tables(collected, (TaxelArray("row", 1, 3, 1e-3, 1e-3),))
    assert "(+1.00, +0.00) +0.150 ? +0.400, inside, 2 taxels" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["=1+1", "+a", "-0+0", "@x", "\tx"])
def test_text_cells_are_no_formulas_and_codes_no_numbers(text: str) -> None:
    assert text_cell(text) == f"'{text}"
    assert text_cell("a" + text) == "a" + text
    assert text_cell("0000", always=True) == "'0000"


def test_a_run_without_events(capsys: pytest.CaptureFixture[str]) -> None:
    tables(Collected(), (TaxelArray("pad", 2, 2, 1e-3, 1e-3),))
    assert capsys.readouterr().out.splitlines()[0] == "no events"


@pytest.mark.parametrize(("width", "most"), [(60, 2), (80, 2), (150, 1)])
def test_an_event_takes_at_most_two_lines(
    width: int, most: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tactile.output.tables.console", lambda: Console(width=width))
    arrays = tuple(TaxelArray(name, 2, 2, 1e-3, 1e-3) for name in ("left", "right"))
    load = Load(1e-3, -2e-3, 0.1, 0.2, 4.2, taxels=4, validity=Validity.INSIDE)
    collected = Collected()
    collected.take(
        [Event(n, "left", n, "release", {}, "release", "·→ ··", "00000000", 0, 1e-4, load) for n in range(9)], []
    )
    tables(collected, arrays)
    shown = capsys.readouterr().out.splitlines()
    body = [line for line in shown if line.startswith("│")]
    assert len(body) == 9 * most
    assert max(map(len, shown)) <= width
    assert sum("(+1.00, -2.00) +0.100 +0.200 +4.200" in line for line in body) == 9
    assert ("columns without room: hand" in " ".join(shown)) == (width < 150)


def test_outputs_of_programs_in_json_and_the_last_in_the_table(
    capsys: pytest.CaptureFixture[str],
) -> None:
    collected, array = Collected(), TaxelArray("pad", 2, 2, 1e-3, 1e-3)
    plane = np.array([[True, False], [False, False]])
    collected.outputs = [
        ProgramOutput(n / 10, "pad", "mine", {"here": plane, "level": np.array([0.5, np.nan]), "count": n})
        for n in range(8)
    ]
    programs = json.loads(json.dumps(run_data(collected, (array,), Settings()), allow_nan=False))["programs"]
    assert len(programs) == 8
    assert programs[2] == {
        "t_s": 0.2, "finger": "pad", "program": "mine",
        "outputs": {"here": [[1, 0], [0, 0]], "level": [0.5, None], "count": 2},
    }  # fmt: skip
    tables(collected, (array,))
    shown = capsys.readouterr().out
    assert "3 earlier outputs of programs not shown" in shown
    assert shown.count("mine: here") == 5
