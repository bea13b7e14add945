"""The list of what detectors see, on a terminal."""

import json

import pytest
from click.testing import CliRunner

from tactile.cli.group import main


def test_planes_fit_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = CliRunner().invoke(main, ["planes"]).output.splitlines()
    assert max(map(len, lines)) <= 80
    names = set(json.loads(CliRunner().invoke(main, ["planes", "--json"]).output))
    assert names == {line.split()[0] for line in lines if not line.startswith(" ")}
