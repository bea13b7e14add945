"""The example of the page on own recordings runs."""

import re
from pathlib import Path
from typing import Any

import pytest

from tactile.layout.layout import parse_layout
from tests.kits.paths import ROOT
from tests.kits.serial import call


def test_the_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "bring-your-own-recording.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(\w*)\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    for language, code in blocks:
        if language == "python":
            exec(compile(code, "page", "exec"), names)
        elif language == "toml":
            assert parse_layout(code, "page").fingers[0].board.chips == 3
        else:
            for line in (one.split("#")[0] for one in code.splitlines()):
                result = call(*line.split()[1:])
                assert result.exit_code == 0, result.output
    assert [event.words for event in names["result"].events] == [
        "contact on 4 of 4 taxels",
        "load",
        "hold 1.20 N",
        "release",
    ]
