"""Texts of files and command lines reach a terminal as they are written, and move, colour or mark up nothing."""

import json
import re
from io import StringIO
from pathlib import Path

import pytest
from click.testing import CliRunner
from rich.panel import Panel
from rich.table import Table

from cnnsim.cli.group import main as cnnsim
from cnnsim.support.command_line import watched
from cnnsim.support.terminal import as_markup, console, json_line, printable
from tactile.cli.group import main as tactile
from tests.kits.paths import ROOT

NASTY = "\x1b[2J\x1b]0;title\x07\x9b31m\u202egnp.exe\r\x08 [/x] [red]left[/red] :boom:"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]")
TEMPLATE = """
name = "odd"
summary = {text}
reference = {text}
note = {text}
tags = ["odd"]
A = 2
B = 0
z = 0
input = "none"
initial_state = "picture"
boundary = "zero-flux"
duration = "settled"
"""
SCENE = """
title = {text}
rate_hz = 100.0
duration_s = 0.5
[cover]
youngs_modulus_mpa = 1.0
[[finger]]
name = "thumb"
rows = 2
cols = 2
pitch_mm = 4.0
depth_mm = 1.5
[[load]]
finger = "thumb"
path = [[0.0, 0.0, 0.0, 0.0, 0.0, 0.5]]
"""
TEXT = '"' + "".join(f"\\u{ord(c):04x}" if not c.isprintable() else c for c in NASTY) + '"'


def test_control_characters_become_question_marks() -> None:
    assert printable("a\tb\nc\x1b[0m\x7f\u2028\udc80ü") == "a\tb\nc?[0m???ü"
    assert not CONTROL.search(printable(NASTY))


def test_lines_of_json_hold_no_control_character_and_say_the_same() -> None:
    line = json_line({"text": NASTY, "arrows": "\u2197"})
    assert json.loads(line) == {"text": NASTY, "arrows": "\u2197"}
    assert not CONTROL.search(line)
    assert "\u2197" in line


def test_a_console_shows_markup_as_text(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = console()
    screen.file = StringIO()
    table = Table("[red]head[/red]", title="[/t]")
    table.add_row(NASTY)
    screen.print(table, NASTY)
    shown = screen.file.getvalue()
    assert shown.count("[/x]") == 2
    assert "[red]head" in shown
    assert not CONTROL.search(shown)
    screen.print(Panel("x", title=as_markup("[/x] [left]")))
    assert "[/x] [left]" in screen.file.getvalue()


def test_a_bar_of_progress_takes_any_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert list(watched([1, 2], NASTY)) == [1, 2]


def test_names_and_texts_of_files_are_shown_harmless(tmp_path: Path) -> None:
    (tmp_path / "odd.toml").write_text(TEMPLATE.format(text=TEXT), encoding="utf-8")
    library = ["--library", str(tmp_path)]
    for command in (["list", "--tag", "odd"], ["show", "odd"], ["explain", "odd"]):
        result = CliRunner().invoke(cnnsim, [*library, *command])
        assert result.exit_code == 0, result.output
        assert not CONTROL.search(result.output)
    assert "[/x] [red]left[/red] :boom:" in CliRunner().invoke(cnnsim, [*library, "show", "odd"]).output


def test_a_scene_s_title_is_shown_harmless(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.format(text=TEXT), encoding="utf-8")
    result = CliRunner().invoke(tactile, ["explain", str(path)])
    assert "[/x] [red]left[/red] :boom:" in result.output
    assert not CONTROL.search(result.output)


@pytest.mark.parametrize("command", [
    ["run", NASTY, "x.png"], ["show", "edge", NASTY], ["--" + NASTY], [NASTY], ["run", "edge", NASTY],
    ["explain", "edge", "--size", NASTY], ["run", "edge", "x.png", "--backend", NASTY], ["program", NASTY + ".toml"],
])  # fmt: skip
def test_what_was_typed_is_quoted_harmless(command: list[str]) -> None:
    result = CliRunner().invoke(cnnsim, [word.replace("\0", "") for word in command])
    assert result.exit_code == 2
    assert "Traceback" not in result.output
    assert not CONTROL.search(result.output)


def test_modules_print_with_the_functions_of_terminal() -> None:
    """Texts of files may hold control characters and markup."""
    printing = re.compile(r"click\.s?echo\(|(?<![\w.])print\((?!\*)|\bConsole\(|from_markup\(")
    paths = [path for package in ("cnnsim", "tactile") for path in (ROOT / package).rglob("*.py")]
    assert [path.name for path in paths if printing.search(path.read_text("utf-8"))] == ["terminal.py"]
