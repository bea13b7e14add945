"""`tactile score` on sequences of a magnetometer board, slipping or still: accuracy, onsets, wrong files."""

import json
from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.score.sequences import onset, plain_detector, read_sequences
from tactile.wire.description_file import read_description
from tests.kits.serial import call
from tests.kits.touch.sequences import RATE, START, write_sequences


def test_the_onset_is_the_start_of_growth() -> None:
    rng = np.random.default_rng(1)
    for start in (60, 100, 150):
        norm = 10 + 20 * np.maximum(np.arange(250) - start, 0) + 5 * rng.standard_normal(250)
        assert abs(onset(norm) - start) <= 3
        assert plain_detector(norm) in range(start, start + 20)
    assert plain_detector(10 + rng.standard_normal(250)) is None


def test_sequences_are_classified_at_every_gain(tmp_path: Path) -> None:
    file, board = write_sequences(tmp_path)
    done = call("score", file, "--array", board, "--gain", "0.25", "--gain", "4", "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)["sequences"]["readings"]
    assert set(found) == {"x 0.25", "x 4", "baseline: norm"}
    for one in found.values():
        assert (one["accuracy"], one["false_rate"], one["missed"]) == (1.0, 0.0, 0)
    assert found["x 0.25"]["onset_error_s"] == found["x 4"]["onset_error_s"]
    assert abs(found["x 4"]["onset_error_s"][1]) < 0.2
    assert found["x 4"]["told_after_s"][1] > found["x 4"]["onset_error_s"][1]
    still = call("score", file, "--array", board, "--kind", "release")
    assert "accuracy 0.500" in still.stdout.splitlines()[1]


def test_given_onsets_are_used_and_wrong_files_refused(tmp_path: Path) -> None:
    file, board = write_sequences(tmp_path, onset_s=np.array([1.19, np.nan, np.nan, np.nan]))
    description = read_description(board)
    sequences = read_sequences(file, description)
    assert sequences.onset[0] == 1.19
    assert sequences.onset[2] == pytest.approx(START / RATE, abs=0.05)
    source = sequences.source(0, description, 2.0)
    frame = next(iter(source))
    assert frame.values[0, 1] == pytest.approx(2 * sequences.signal[0, 0, 1])
    assert not frame.valid[0, 0]
    for wrong, message in (
        ({"signal": np.zeros((4, 250, 12))}, r"\(sequences, frames, 15\)"),
        ({"slip": np.zeros(3)}, r"slip of \(3,\)"), ({"signal": np.zeros((4, 60, 15))}, "more than 80 wanted"),
        ({"rate_hz": np.array(-1.0)}, "a positive number wanted"),
    ):  # fmt: skip
        write_sequences(tmp_path, **wrong)
        with pytest.raises(InputError, match=message):
            read_sequences(file, description)
    with pytest.raises(InputError, match="none"):
        read_sequences(tmp_path / "none.npz", description)


def test_uncalibrated_strain_is_refused_or_warned_about(tmp_path: Path) -> None:
    """Strain without gains is refused; with wrong gains, the low explained share is reported."""
    signal = np.load(write_sequences(tmp_path)[0])["signal"]
    pressed = np.array([-4.0, 3.0, -5.0, 2.0, -3.0])  # a pattern of magnets, not of strain
    signal[:, :, 2::3] += pressed * np.maximum(np.arange(250) - START, 0)[:, None]
    file, board = write_sequences(tmp_path, signal=signal)
    known = board.read_text(encoding="utf-8")
    strain = "youngs_modulus_mpa = 0.4" + known.replace('"force"', '"strain"').replace(
        "depth_mm = 0.0", "depth_mm = 2.0"
    )
    board.write_text(strain, encoding="utf-8")
    refused = call("score", file, "--array", board)
    assert refused.exit_code == 2
    assert 'quantity = "force"' in refused.output
    board.write_text(strain + "gains = [1e-4, 1e-4]\n", encoding="utf-8")
    done = call("score", file, "--array", board, "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["sequences"]["explained"] < 0.5
    assert "not those of the array" in done.stderr
    board.write_text(known, encoding="utf-8")
    done = call("score", file, "--array", board, "--json")
    assert json.loads(done.stdout)["sequences"]["explained"] is None
    assert "not those of the array" not in done.stderr
