"""`tactile run FOLDER`: one table of events of all recordings, with the errors of those that cannot be read."""

import csv
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from tactile.cli.group import main
from tactile.output.event_table import COLUMNS
from tactile.sources.convert import convert
from tests.kits.touch.source import SCENE

KINDS = ("csv", "mcap", "npz", "parquet")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("made")
    (made / "a.toml").write_text(SCENE)
    for kind in KINDS:
        convert(made / "a.toml", made / f"a.{kind}")
    (made / "b.npz").write_bytes((made / "a.npz").read_bytes()[:500])
    (made / "c.csv").write_text("# tactile_recording = 1\nhello\n")
    (made / "labels.csv").write_text("recording,sensor,contact_s\na,0,0.02\n")
    (made / "notes.txt").write_text("not a recording")
    return made


def test_recordings_of_all_kinds_in_one_table(folder: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["run", str(folder), "-o", str(tmp_path), "--parquet", "--sigmas", "3", "5", "3"])
    assert done.exit_code == 0, done.output
    assert "7 recordings, " in done.stdout
    assert "2 could not be run" in done.stdout
    text = (tmp_path / "events.csv").read_text(encoding="utf-8")
    head = dict(line[2:].split(" = ", 1) for line in text.splitlines() if line.startswith("# "))
    facts = {name: json.loads(value) for name, value in head.items()}
    assert facts["tactile_events"] == 1
    assert facts["options"]["sigmas"] == [3, 5, 3]
    assert facts["units"]["strain"] == "1"
    assert facts["recordings"][0]["sigmas"] == {"dead_band": 3, "hysteresis": 5, "contact": 3}
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("# ")))
    assert tuple(rows[0]) == tuple(COLUMNS)
    by_name = {name: [row for row in rows if row["recording"] == name] for name in {row["recording"] for row in rows}}
    assert sorted(by_name) == ["a.csv", "a.mcap", "a.npz", "a.parquet", "a.toml", "b.npz", "c.csv"]
    scene = [{**row, "recording": ""} for row in by_name["a.toml"]]
    assert "contact" in [row["kind"] for row in scene]
    contact = scene[0]
    assert float(contact["shear_on"]) > float(contact["shear_off"]) > 0 < float(contact["normal_on"])
    assert (contact["unit"], contact["error"]) == ("1", "")
    assert 0 < float(contact["load_f_n"]) <= 2
    for kind in KINDS:
        assert [{**row, "recording": ""} for row in by_name[f"a.{kind}"]] == scene
    (broken,), (wrong,) = by_name["b.npz"], by_name["c.csv"]
    assert "b.npz: cannot be read as" in broken["error"]
    assert broken["kind"] == wrong["kind"] == ""
    facts_of_json = json.loads(CliRunner().invoke(main, ["run", str(folder), "--json"]).stdout)
    assert sum("error" in one for one in facts_of_json["recordings"]) == 2
    from pyarrow import parquet  # type: ignore[import-untyped]  # it ships no types

    table = parquet.read_table(tmp_path / "events.parquet")
    assert json.loads(table.schema.metadata[b"tactile"]) == facts
    assert [one or "" for one in table.column("words").to_pylist()] == [row["words"] for row in rows]
    assert next(one for one in table.column("t_s").to_pylist() if one is not None) == float(contact["t_s"])


def test_a_folder_without_readable_recordings_is_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "events.csv").write_text("# tactile_events = 1\n")  # an output of this command, not a recording
    for wanted in ("no recordings or scenes in it", "none of 1 could be run; first"):
        done = CliRunner().invoke(main, ["run", str(tmp_path)])
        assert done.exit_code == 2
        assert wanted in done.stderr
        (tmp_path / "b.npz").write_bytes((folder / "b.npz").read_bytes())
