"""Readings that are not finite or huge: counted and reported, without warnings of libraries."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import Array
from tactile.core.frame import Frame, TaxelArray
from tactile.output.invalid_readings import InvalidReadings
from tactile.sources import open_source
from tactile.sources.replay_npz import write_npz
from tests.kits.paths import ROOT
from tests.kits.serial import call

GRASP = ROOT / "examples" / "grasp.npz"


def damaged(path: Path, value: float, share: float) -> tuple[Path, Array]:
    """Write the example with ``value`` in a share of its readings; return the mask of those of its first finger."""
    with np.load(GRASP) as file:
        arrays = {name: file[name] for name in file.files}
    hit = np.random.default_rng(3).random(arrays["s0_valid"].shape) < share
    for name in ("s0_values", "s1_values"):
        arrays[name] = np.where(hit[..., None], value, arrays[name])
    np.savez(path, **arrays)
    return path, hit


def ran(path: Path, *more: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = call("run", path, *more)
    assert done.exit_code == 0, done.output
    return done


@pytest.mark.parametrize("value", [np.nan, -1.7e308])
def test_a_recording_without_valid_readings(value: float, tmp_path: Path) -> None:
    path, _ = damaged(tmp_path / "r.npz", value, 1.0)
    done = ran(path, "-o", tmp_path / "out")
    assert "no events" in done.stdout
    for finger in ("left", "right"):
        assert f"{finger}: no taxel could be read in any of 1200 frames" in done.stderr


@pytest.mark.parametrize("value", [np.nan, 1e300])
def test_valid_readings_are_used_and_invalid_ones_counted(value: float, tmp_path: Path) -> None:
    path, hit = damaged(tmp_path / "r.npz", value, 0.1)
    done = ran(path, "-o", tmp_path / "out")
    frames, empty = int(hit.any((1, 2)).sum()), int(hit.all((1, 2)).sum())
    message = f"left: {int(hit.sum())} readings of taxels in {frames} of 1200 frames could not be read"
    assert message + (f", in {empty} frames none" if empty else "") + "\n" in done.stderr
    marked, _ = damaged(tmp_path / "nan.npz", np.nan, 0.1)
    assert ran(marked, "--json").stdout.count("latency_s") == ran(path, "--json").stdout.count("latency_s") > 10


def test_a_folder_reports_every_recording(tmp_path: Path) -> None:
    damaged(tmp_path / "a.npz", np.nan, 1.0)
    write_npz(tmp_path / "b.npz", open_source(GRASP))
    assert ran(tmp_path).stdout.count("no taxel could be read") == 2


def test_counts_of_a_small_example() -> None:
    array = TaxelArray("tip", 2, 2, 1e-3, 1e-3)
    unread, yes = InvalidReadings((array,)), np.ones((2, 2), bool)
    values = np.zeros((4, 2, 2, 3))
    values[:, 0, 0, 1] = np.nan  # a taxel without a valid reading
    values[1, 1, 1, 2] = np.inf
    values[2] = -np.inf
    marked = np.array([yes, yes, yes, [[True, True], [False, True]]])
    frames = [Frame(0, 0.1 * n, n, one, valid) for n, (one, valid) in enumerate(zip(values, marked, strict=True))]
    assert list(unread.through(frames)) == frames
    assert unread.lines == [
        "tip: 1 of 4 taxels could be read in no frame, 5 readings of other taxels could not be read, in 1 frames none"
    ]
    assert InvalidReadings((array,)).lines == []
