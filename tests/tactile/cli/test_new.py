"""`tactile new` and `tactile planes`; files with several faults name each with its line."""

import json
from pathlib import Path

import pytest

from cnnsim.support import InputError
from tactile.calibration.file import load_calibration
from tactile.sources import open_source
from tactile.wire.description_file import read_description
from tests.kits.serial import call


def test_a_new_scene_runs_unchanged(tmp_path: Path) -> None:
    made = call("new", "scene", "my-touch", "-o", tmp_path)
    path = tmp_path / "my-touch.toml"
    assert made.stdout.splitlines() == [f"-> {path}", f"to run it: tactile run {path} -o out/"]
    done = call("run", path, "--json")
    assert done.exit_code == 0, done.output
    kinds = [event["kind"] for event in json.loads(done.stdout)["events"]]
    assert {"contact", "tangential_load", "release"} <= set(kinds)
    refused = call("new", "scene", "my-touch", "-o", tmp_path)
    assert refused.exit_code == 2
    assert "is there already; --replace" in refused.stderr
    assert call("new", "scene", "my-touch", "-o", tmp_path, "--replace").exit_code == 0
    assert call("new", "scene", "../x", "-o", tmp_path).exit_code == 2


def test_a_new_detector_reports_its_event_on_a_new_scene(tmp_path: Path) -> None:
    call("new", "scene", "my-touch", "-o", tmp_path)
    made = call("new", "detector", "my-events", "-o", tmp_path)
    path = tmp_path / "my-events.toml"
    assert made.stdout.splitlines()[0] == f"-> {path}"
    done = call("run", tmp_path / "my-touch.toml", "--program", path, "--json")
    assert done.exit_code == 0, done.output
    events = json.loads(done.stdout)["events"]
    assert [event["words"] for event in events if event["kind"] == "together"] == ["3 of 4 taxels together"]


def test_the_commented_lines_of_a_new_scene_are_valid(tmp_path: Path) -> None:
    call("new", "scene", "all", "-o", tmp_path)
    text = (tmp_path / "all.toml").read_text()
    lines = [line.removeprefix("# ") if " = " in line or line.startswith("# [") else line for line in text.splitlines()]
    lines = [line for line in lines if not line.startswith(("kind =", "Try it"))]
    (tmp_path / "all.toml").write_text("\n".join(lines))
    scene = open_source(tmp_path / "all.toml")
    assert sum(1 for _ in scene) == 400


def test_a_new_array_describes_a_device(tmp_path: Path) -> None:
    assert call("new", "array", "my-skin", "-o", tmp_path).exit_code == 0
    description = read_description(tmp_path / "my-skin.toml")
    assert [array.shape for array in description.arrays] == [(2, 2)]
    description.check_calibrated()


def test_all_faults_of_a_file_are_reported_with_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "x.toml"
    path.write_text('title = "t"\nrate = 3\n[cover]\n[[finger]]\nname = "a"\nrow = 2\n[[load]]\npath = []\n'
                    "[[contact]]\n[effect.read_noise]\nrmss = 1\n")  # fmt: skip
    with pytest.raises(InputError) as caught:
        open_source(path)
    message = str(caught.value)
    for fault in (
        "unknown key 'rate' (line 2)", "no 'rate_hz', 'duration_s'", "[cover]: no 'youngs_modulus_mpa' (line 3)",
        "finger 1: unknown key 'row' (line 6)", "no 'rows', 'cols', 'pitch_mm', 'depth_mm' (line 4)",
        "load 1: no 'finger' (line 7)", "contact 1: no 'finger', 'shape', 'path' (line 9)",
        "[effect.read_noise]: unknown key 'rmss' (line 11)",
    ):  # fmt: skip
        assert fault in message, message
    assert message.count(str(path)) == 1
    path.write_text('protocol = "native"\nbaud = 3\n[[finger]]\nname = "a"\nrow = 2\n')
    pattern = r"'baud' \(line 2\).*finger 1: unknown key 'row' \(line 5\).*no 'rows', 'cols'"
    with pytest.raises(InputError, match=pattern):
        read_description(path)
    path.write_text("shear = 1.0\n[radial]\n")
    missing = r"'shear' \(line 1\).*no 'shear_gain', 'normal_gain', 'depth_mm'.*\[radial\]: no 'located_um', 'true_um'"
    with pytest.raises(InputError, match=missing):
        load_calibration(path)


def test_the_list_of_planes_fits_a_terminal_of_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = call("planes").output.splitlines()
    assert max(map(len, lines)) <= 80
    names = set(json.loads(call("planes", "--json").output))
    assert names == {line.split()[0] for line in lines if not line.startswith(" ")}
