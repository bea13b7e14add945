"""What accuracy costs in a scene: errors found are below bounds and tolerances, files are written."""

import csv
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from tactile.cli.accuracy import accuracy as command
from tactile.simulator.choice.tradeoff import FRAMES, shortened, trades
from tactile.simulator.effects.read_noise import ReadNoise
from tests.kits.paths import SCENES
from tests.kits.touch.random_scenes import needle


def test_errors_are_within_bounds_and_time_falls_with_what_is_left_out() -> None:
    whole, strict, loose = trades(needle().with_effects([]), (0.003, 0.3), seeds=2, rounds=2)
    assert whole.left_out == ()
    for one in (strict, loose):
        assert one.error <= one.bound <= one.tolerance
    assert set(strict.left_out) < set(loose.left_out)
    assert loose.seconds < whole.seconds


def test_a_long_scene_is_shortened() -> None:
    assert shortened(needle(duration=100.0)).samples <= FRAMES
    assert shortened(needle()).samples == needle().samples


def test_the_command_writes_figures(tmp_path: Path) -> None:
    table, picture = tmp_path / "a.csv", tmp_path / "a.png"
    given = [str(SCENES / "needle.toml"), "--tolerance", "0.1", "--csv", str(table), "-o", str(picture), "--json"]
    done = CliRunner().invoke(command, given)
    assert done.exit_code == 0, done.output
    rows = json.loads(done.stdout)["rows"]
    assert [row["tolerance"] for row in rows] == [0.0, 0.1]
    with table.open(encoding="utf-8") as file:
        kept = list(csv.DictReader(file))
    assert float(kept[1]["error"]) == rows[1]["error"] <= 0.1
    assert picture.read_bytes().startswith(b"\x89PNG")
    done = CliRunner().invoke(command, [str(SCENES / "needle.toml"), "--tolerance", "0"])
    assert "tolerance 0" in str(done.exception)


def test_an_effect_at_zero_costs_nothing_to_leave_out() -> None:
    (_, one) = trades(needle(("read_noise", ReadNoise(1e-6))), (0.01,), seeds=1, rounds=1)
    assert one.error == pytest.approx(0, abs=1e-3)
