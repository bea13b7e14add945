"""What ``tactile run`` prints: columns that fit, figures that can be read, nothing besides."""

import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from tactile.cli.group import main
from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected
from tactile.output.json_data import run_data
from tactile.output.record import text_cell
from tactile.output.tables import tables
from tactile.pipeline import FrameReport, warm_up
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
    assert all(line.startswith("│") == line.endswith("│") for line in lines)  # no cell is wrapped into the next line
    assert not any(line.startswith("│          │") for line in lines)
    assert not shown.stderr
    plain = CliRunner().invoke(main, ["run", str(GRIP), "--json"])
    assert json.loads(plain.stdout)["frames"] == 2400
    assert not plain.stderr


@pytest.mark.parametrize("quantity", ["strain", "stress", "force"])
def test_warming_up_touches_every_array(quantity: Any) -> None:
    """A tare at the start does not keep it from the inverse and the comparators."""
    arrays = TaxelArray("a", 2, 2, 1e-3, 1e-3, quantity=quantity), TaxelArray("b", 3, 3, 1e-3, 1e-3, quantity=quantity)
    reports: list[FrameReport] = []
    warm_up(arrays, 1e6, Settings(tare=100), [reports.append])
    assert {report.array.name for report in reports} == {"a", "b"}
    assert all(report.frame.valid.all() for report in reports if report.frame.t > 0.5)  # then there is an offset
    kinds = {(event.finger, event.kind) for report in reports for event in report.events}
    assert kinds >= {(name, kind) for name in "ab" for kind in ("contact", "hold", "release")}


@pytest.mark.parametrize(
    ("side", "code", "hand"), [(2, True, True), (4, True, True), (5, False, True), (8, False, False)]
)
def test_codes_of_many_taxels_stay_in_the_record(
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


def test_a_force_that_is_not_known_keeps_its_place(capsys: pytest.CaptureFixture[str]) -> None:
    """One row of taxels tells nothing of the shear across it: without a mark F would stand where R stands."""
    load = Load(1e-3, 0.0, 0.15, float("nan"), 0.4, taxels=2, validity=Validity.INSIDE)
    collected = Collected()
    collected.take([Event(1.0, "row", 3, "release", {}, "release", "···", "000", 0, 1e-4, load)], [])
    tables(collected, (TaxelArray("row", 1, 3, 1e-3, 1e-3),))
    assert "(+1.00, +0.00) +0.150 ? +0.400, inside, 2 taxels" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["=1+1", "+a", "-0+0", "@x", "\tx"])
def test_a_cell_of_text_is_no_formula_and_a_code_no_number(text: str) -> None:
    assert text_cell(text) == f"'{text}"
    assert text_cell("a" + text) == "a" + text
    assert text_cell("0000", always=True) == "'0000"


def test_a_run_without_events_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    tables(Collected(), (TaxelArray("pad", 2, 2, 1e-3, 1e-3),))
    assert capsys.readouterr().out.splitlines()[0] == "no events"


@pytest.mark.parametrize(("width", "most"), [(60, 2), (80, 2), (150, 1)])
def test_an_event_takes_two_lines_at_most(
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
    assert ("no room for: hand" in " ".join(shown)) == (width < 150)


def test_what_programs_put_out_is_in_the_json_and_the_last_of_it_in_the_table(
    capsys: pytest.CaptureFixture[str],
) -> None:
    collected, array = Collected(), TaxelArray("pad", 2, 2, 1e-3, 1e-3)
    plane = np.array([[True, False], [False, False]])
    collected.outputs = [
        (n / 10, "pad", "mine", {"here": plane, "level": np.array([0.5, np.nan]), "count": n}) for n in range(8)
    ]
    told = json.loads(json.dumps(run_data(collected, (array,), Settings()), allow_nan=False))["programs"]
    assert len(told) == 8
    assert told[2] == {
        "t_s": 0.2, "finger": "pad", "program": "mine",
        "outputs": {"here": [[1, 0], [0, 0]], "level": [0.5, None], "count": 2},
    }  # fmt: skip
    tables(collected, (array,))
    shown = capsys.readouterr().out
    assert "3 outputs of programs before these" in shown
    assert shown.count("mine: here") == 5


@pytest.mark.parametrize("width", [32, 40, 60])
def test_a_narrow_table_keeps_times_and_fingers(
    width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    collected, array = Collected(), TaxelArray("thumb", 2, 2, 1e-3, 1e-3)
    load = Load(1e-3, -2e-3, -0.1, 0.2, 0.42, taxels=4, validity=Validity.INSIDE)
    words = "separate contacts on 12 taxels"
    event = Event(12.345, "thumb", 0, "two_blobs", {}, words, "....", "00", 0, 1e-3, load, end=13.0)
    collected.take([event], [])
    monkeypatch.setattr("tactile.output.tables.console", lambda: Console(width=width))
    tables(collected, (array,))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= width
    assert any("12.345" in line and "thumb" in line for line in lines)
    cells = " ".join(line.split("│")[3].strip() for line in lines if line.startswith("│"))
    assert words in cells
    assert "+0.420" in cells.replace(" ", "")
