"""Error and time by tolerance: measured errors are below bounds and tolerances, files are written."""

import csv
import json
from pathlib import Path

from click.testing import CliRunner

from tactile.cli.accuracy import accuracy as command
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.tradeoff import trades
from tests.kits.paths import SCENES
from tests.kits.touch.random_scenes import needle


def test_errors_are_within_bounds() -> None:
    scene = needle(("taxel_area", TaxelArea()), ("drift", Drift(0.008, 0.001)), ("read_noise", ReadNoise(1e-4)))
    whole, strict, loose = trades(scene, (0.01, 0.3), seeds=2, rounds=2)
    assert whole.left_out == ()
    for one in (strict, loose):
        assert 0 < one.error <= one.bound <= one.tolerance
    assert set(strict.left_out) < set(loose.left_out)


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
