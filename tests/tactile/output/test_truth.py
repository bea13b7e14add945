"""Ground truth of scenes and the errors of located loads, in frames.csv, Parquet, JSON and the table."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.output.ground_truth import GroundTruth, truth_of
from tactile.pipeline import FrameReport, run
from tactile.settings import Settings
from tactile.simulator.scene_file.file import scene_from
from tactile.sources.replay_csv import write_csv
from tests.kits.serial import GRIP, call, grip
from tests.kits.touch.source import parsed


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_errors_against_the_ground_truth(tmp_path: Path) -> None:
    shown = call("run", GRIP, "-o", tmp_path / "out")
    assert "left: error against the ground truth:" in shown.stdout
    rows = [row for row in table(tmp_path / "out" / "frames.csv") if row["finger"] == "left"]
    held = next(row for row in rows if float(row["t_s"]) == 2.5)
    true = [float(held[f"true_{name}"]) for name in ("x_m", "y_m", "q_n", "r_n", "f_n")]
    assert true == pytest.approx([0.2e-3, -0.3e-3, 0.02, 0.30, 0.60])
    assert 0 <= float(held["error_m"]) < 1e-9
    assert 0 <= float(held["error_n"]) < 1e-6
    first = rows[0]
    assert (first["true_loads"], first["true_x_m"], first["error_m"]) == ("0", "nan", "nan")
    errors = json.loads(call("run", GRIP, "--json").stdout)["fingers"]["left"]["error"]
    assert errors["frames"] > 500
    assert errors["place_max_m"] < 1e-3


def test_parquet_equals_the_csv_table(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="the serial extra is not installed")
    shown = call("run", GRIP, "-o", tmp_path / "out", "--parquet")
    assert "frames.parquet" in shown.stdout
    columns = parquet.read_table(tmp_path / "out" / "frames.parquet").to_pydict()
    rows = table(tmp_path / "out" / "frames.csv")
    assert list(columns) == list(rows[0])
    for name, values in columns.items():
        written = [row[name] for row in rows]
        if isinstance(values[0], str):
            assert values == [text.removeprefix("'") for text in written]
        else:
            np.testing.assert_array_equal(values, np.array(written, np.float64))
    assert {type(columns[name][0]) for name in ("sequence", "load_taxels", "true_loads")} == {int}
    refused = call("run", GRIP, "--parquet")
    assert refused.exit_code == 2
    assert "-o FOLDER wanted" in refused.output


def test_recordings_have_no_ground_truth(tmp_path: Path) -> None:
    write_csv(tmp_path / "g.csv", grip(0.5))
    plain = call("run", tmp_path / "g.csv", "-o", tmp_path / "out", "--json")
    assert json.loads(plain.stdout)["fingers"]["left"]["error"] is None
    assert "true_x_m" not in table(tmp_path / "out" / "frames.csv")[0]


def test_the_nearest_load_at_the_time_of_the_frame() -> None:
    """Also for late frames and after dropped ones."""

    def load(x: float) -> dict[str, Any]:
        return {"finger": "left", "path": [[0.0, x, 0, 0, 0, 1], [0.1, x, 0.2, 0, 0, 1]]}

    effect = {"frame_timing": {"jitter_ms": 2.0, "drops": 0.2}}
    scene = scene_from(parsed(load=[load(-0.5), load(0.5)], effect=effect, duration_s=0.09, seed=3), "here")
    truth, frames = GroundTruth(scene), 0

    def check(report: FrameReport) -> None:
        nonlocal frames
        frames += 1
        wanted = scene.loads_at(0, np.array([report.frame.sequence / scene.rate]))[0]
        found = truth(report)
        assert found.pressing == 2
        assert [found.x, found.y, found.Q, found.R, found.F] in wanted.tolist()

    run(scene, Settings(backend="reference"), [check])
    assert 3 < frames <= 9
    assert truth_of(object()) is None
