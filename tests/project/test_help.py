"""Help of the commands: one word for one thing, lines that fit, and extras that are there."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from cnnsim.cli.group import main as cnnsim
from cnnsim.support.extras import install_line
from tactile.cli.group import main as tactile
from tests.kits.paths import ROOT

GROUPS = {"cnnsim": cnnsim, "tactile": tactile}


@pytest.mark.parametrize("extra", ["serial", "opencl", "fem", "video"])
def test_the_line_that_installs_an_extra_names_something_that_is_there(extra: str) -> None:
    line = install_line(extra)
    assert line.startswith("pip install ")
    place = re.search(rf"(/[^'\[]*)\[{extra}\]", line)
    assert place is None or Path(place[1]).exists()
    assert "cellular-wave-touch[" not in line.replace(str(ROOT), "")


def test_one_word_lets_a_command_write_over_what_is_there() -> None:
    written_over = re.compile(r"write over|overwrite|replace (the|a|target|what)|^replace\b", re.IGNORECASE)
    named = {
        (group, name, *option.opts)
        for group, main in GROUPS.items()
        for name, command in main.commands.items()
        for option in command.params
        if getattr(option, "is_flag", False) and written_over.search(getattr(option, "help", None) or "")
    }
    assert len(named) >= 9
    assert {word for _, _, *words in named for word in words} == {"--replace"}


@pytest.mark.parametrize("words", [["cnnsim"], ["tactile"], ["tactile", "texture"]], ids=" ".join)
def test_every_summary_fits_in_one_line_of_the_help(words: list[str]) -> None:
    text = CliRunner().invoke(GROUPS[words[0]], [*words[1:], "--help"], terminal_width=80).output
    summaries = text.split("Commands:\n")[1].split("\n\n")[0].splitlines()
    assert len(summaries) >= 3
    assert not [line for line in summaries if line.endswith("...")]
