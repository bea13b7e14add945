"""Wrong scenes, recordings and options: one line of error and exit code 2; warnings."""

from pathlib import Path

import numpy as np
import pytest

from tactile.core.epoch import Epoch
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.recording.writer import Recording
from tactile.sources import open_source
from tactile.sources.replay_csv import write_csv
from tactile.wire.description_file import parse_description
from tactile.wire.source import Chunk
from tests.kits.serial import GRIP, call, sent
from tests.kits.touch.one_finger import run_command, write_scene


@pytest.mark.parametrize(("change", "message"), [
    (("[cover]", "[covers]"), "did you mean"),
    (("rows = 3", "rows = 0"), "finger 1: rows = 0, a whole number from 1 up wanted (line "),
    (("pitch_mm = 1.0", "pitch_mm = -1.0"), "pitch"),
    (("[[load]]", "[[lod]]"), "lod"),
    (('finger = "tip"', 'finger = "toe"'), "toe"),
    (("[[0.5, -0.3", "[[0.5"), "keyframe"),
    (("title =", "title"), "TOML"),
])  # fmt: skip
def test_a_wrong_scene_is_refused_in_one_line(change: tuple[str, str], message: str, tmp_path: Path) -> None:
    path = write_scene(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    result = run_command(path)
    assert (result.exit_code, result.stdout) == (2, "")
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_wrong_options_are_refused(tmp_path: Path) -> None:
    for arguments, message in (
        ((tmp_path / "none.toml",), "no scene or recording"),
        ((GRIP, "--sign-code", "--dead-band", "1"), "--sign-code has no dead band"),
        ((GRIP, "--hysteresis", "1"), "hysteresis needs a dead_band"),
        ((GRIP, "--dead-band", "-1"), "dead_band is -1.0"),
        ((GRIP, "--window", "0"), "window"),
        ((GRIP, "--gains", "2"), "two numbers SHEAR,NORMAL wanted"),
        ((GRIP, "--gains", "0,1"), "shear gain 0.0"),
        ((GRIP, "--tare", "-1"), "-1 frames; 0 or more wanted"),
        ((GRIP, "-o", GRIP), "cannot make the folder"),
    ):
        result = run_command(*arguments)
        assert result.exit_code == 2, arguments
        assert message in result.stderr
        assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("offset", "options", "warned"), [(0.5, (), True), (0.5, ("--tare", "off"), False), (0.0, (), False)]
)
def test_contact_from_the_first_frame_is_warned_about(
    offset: float, options: tuple[str, ...], warned: bool, tmp_path: Path
) -> None:
    array = TaxelArray("pad", 2, 2, 1e-3, 0.0, quantity="force")
    frames = [Frame(0, n / 100, n, np.full((2, 2, 3), offset), np.ones((2, 2), bool)) for n in range(60)]
    write_csv(tmp_path / "pad.csv", FrameStream("pad", (array,), None, 60, frames))
    result = run_command(tmp_path / "pad.csv", *options)
    assert result.exit_code == 0
    assert ("pad: in contact from the first frame, without a tare" in result.stderr) == warned


def test_a_truncated_csv_names_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "cut.csv"
    write_csv(path, open_source(write_scene(tmp_path)))
    path.write_text(path.read_text(encoding="utf-8")[:-40], encoding="utf-8")
    result = run_command(path)
    assert result.exit_code == 2
    assert "cut.csv" in result.stderr
    assert "line" in result.stderr


@pytest.mark.parametrize("arguments", [
    ("score", "--grasps", "99999999999999"), ("score", "--idle-minutes", "nan"),
    ("score", "--grasps", "1", "--window-ms", "nan"),
    ("score", GRIP, "--array", GRIP, "--gain", "inf"), ("replay", "a.mcap", "--speed", "nan"),
    ("live", "-p", "x", "--seconds", "inf"), ("record", "-p", "x", "-o", "a.mcap", "--seconds", "nan"),
    ("texture", "classify", "a.npz", "--model", "b.npz", "--confidence", "nan"),
    ("emulate", "--protocol", "native", "--scene", GRIP, "--seed", "-1"),
])  # fmt: skip
def test_numbers_out_of_range_are_refused(arguments: tuple[object, ...]) -> None:
    result = call(*arguments)
    assert result.exit_code == 2
    assert "a finite number wanted" in result.stderr or "not in the range" in result.stderr


def test_a_recording_with_the_wrong_description_is_warned_about(tmp_path: Path) -> None:
    described, stream = sent("native", 0.3)
    for cols, warning in ((2, ""), (3, "unfit")):
        text = described.text.replace("cols = 2", f"cols = {cols}")
        path = tmp_path / f"{cols}.mcap"
        recording = Recording(path, parse_description(text, "array.toml"), {}, Epoch.now())
        for t, data in stream:
            recording.chunk(Chunk(round(t * 1e9), data))
            recording.push()
        recording.close({})
        done = run_command(path)
        assert done.exit_code == 0, done.output
        assert ("bytes of the wire: 0 good" in done.stderr) is bool(warning)
        assert warning in done.stderr
        assert f"left 2 x {cols}, right 2 x {cols}" in done.stderr or not warning


def test_millinewtons_are_not_printed_as_newtons(tmp_path: Path) -> None:
    array = TaxelArray("pad", 2, 2, 5e-3, 0.0, quantity="force")
    rng, press, stop = np.random.default_rng(0), np.array([0, 0, 1500.0]), 300
    frames = [
        Frame(0, 5e-3 * n, n, rng.normal(0, 2, (2, 2, 3)) + press * (60 < n < 240), np.ones((2, 2), bool))
        for n in range(stop)
    ]
    write_csv(tmp_path / "mn.csv", FrameStream("mn", (array,), None, stop, frames))
    shown = run_command(tmp_path / "mn.csv")
    assert "in the unit of the readings" in " ".join(shown.stdout.split()), shown.stdout
    assert "00 N" not in shown.stdout
    assert "if the device sends millinewtons, --gains 0.001,0.001" in shown.stderr
