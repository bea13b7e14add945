"""Checks of tares: subtracted amount, warnings of load and movement, and their remedy."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile import Settings
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import LiveTare
from tactile.calibration.tare_check import TareCheck
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.output.collected import Collected
from tactile.pipeline import run
from tactile.sources.replay_npz import write_npz
from tests.kits.serial import call

PAD = TaxelArray("pad", 3, 3, 4e-3, 0.0, quantity="force")


def checked(values: np.ndarray, array: TaxelArray = PAD, gains: Gains | None = None) -> TareCheck:
    tare = LiveTare(0, array, len(values), gains)
    for n, one in enumerate(values):
        assert not tare.notes
        assert not tare(Frame(0, n * 0.01, n, one, np.ones(array.shape, bool))).valid.any()
    (note,) = tare.notes
    assert note.check is not None
    return note.check


def readings(normal: float = 0.0, shear: float = 0.0, noise: float = 0.003, frames: int = 100) -> np.ndarray:
    out = noise * np.random.default_rng(5).standard_normal((frames, 3, 3, 3))
    out[:, 1, 1] += [shear, 0, normal]
    return out


def test_small_offsets_are_reported_without_a_warning() -> None:
    check = checked(readings(0.05, 0.06))
    assert not check.warning
    assert check.words == "0.05 N normal, 0.06 N shear subtracted, the mean of 100 frames (0.99 s)"


def test_a_load_is_reported_with_its_size_and_remedy() -> None:
    check = checked(readings(4.2))
    assert check.loaded
    assert not check.moving
    assert "4.20 N normal" in check.words
    assert "loaded during the tare, or an offset of that size: record some frames with nothing" in check.warning
    assert "later readings fall 4.00 N below it" in check.then(-4.0, 9).warning
    assert checked(readings(0.0)).then(-0.2, 9).warning == ""
    json.dumps([check.plain(), checked(readings(0.05, 0.06)).plain()])
    assert checked(np.full((100, 3, 3, 3), 0.1)).loaded  # nine small ones of the same sign are a load


def test_a_movement_is_reported_and_one_noisy_taxel_is_not() -> None:
    ramp = np.linspace(0, 1, 100)[:, None, None, None]
    check = checked(readings() + 0.3 * ramp)
    assert check.moving
    assert "moving during the tare, a taxel by 0.2" in check.warning
    noisy = readings()
    noisy[50:, 2, 0, 1] += 0.15
    assert not checked(noisy).warning


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_other_quantities_press_inward_when_negative(quantity: Any) -> None:
    array = TaxelArray("pad", 3, 3, 4e-3, 1e-3, quantity=quantity)
    size = {"strain": 0.02, "stress": 2e4}[quantity]
    check = checked(readings(-size, noise=0.0), array)
    assert check.normal == pytest.approx(size)
    assert check.loaded
    scaled = checked(readings(-size / 8, noise=0.0), array, Gains(2.0, 8.0))
    assert scaled.normal == pytest.approx(size)


def recorded(path: Path, frames: list[np.ndarray]) -> Path:
    stream = [Frame(0, n * 0.01, n, one, np.ones((3, 3), bool)) for n, one in enumerate(frames)]
    write_npz(path, FrameStream("t", (PAD,), None, len(stream), stream, Provenance(untared=True)))
    return path


def test_a_run_reports_the_tare_in_table_json_and_record(tmp_path: Path) -> None:
    pressed = recorded(tmp_path / "r.npz", [*readings(4.2), *readings(0.0)])
    shown = call("run", pressed, "-o", tmp_path / "out")
    assert "pad: tare: 4.20 N normal" in shown.stdout
    assert "pressed during the tare: later readings fall 4." in " ".join(shown.stdout.split())
    plain = call("run", pressed, "--json")
    tare = json.loads(plain.stdout)["fingers"]["pad"]["tare"]
    assert (tare["loaded"], tare["moving"], tare["unit"]) == (True, False, "N")
    assert tare["below"] == pytest.approx(4.2, abs=0.01)
    assert "pad: tare: 4.20 N normal" in plain.stderr
    assert json.loads((tmp_path / "out" / "events.json").read_text())["tares"]["pad"]["loaded"]
    assert json.loads(call("run", pressed, "--json", "--tare", "0").stdout)["fingers"]["pad"]["tare"] is None
    short = recorded(tmp_path / "s.npz", [*readings(0.0, frames=15)])
    assert "pad: no tare in 15 frames (too few); --tare N takes the first N" in call("run", short, "--json").stderr
    assert "pad: tare over 100 frames, 15 there" in call("run", short, "--json", "--tare", "100").stderr


@pytest.mark.parametrize("pressed", [0.0, 1.5])
def test_a_late_tare_reports_the_time_without_readings(pressed: float) -> None:
    """A finger pressed increasingly from its first frame is tared after the release."""
    noise, times = readings(frames=300), 0.01 * np.arange(300)
    noise[:, 1, 1, 2] += np.where(times < pressed, 1 + 2 * times, 0)
    frames = [Frame(0, t, n, one, np.ones((3, 3), bool)) for n, (t, one) in enumerate(zip(times, noise, strict=True))]
    collected = Collected()
    run(FrameStream("pad", (PAD,), None, 300, frames), Settings(tare="auto"), [collected])
    check = collected.tare(PAD)
    assert check is not None
    assert ("before which there are no readings, nor events" in check.warning) is (pressed > 0)
    assert pressed <= check.late <= pressed + (0.5 if pressed else 0)
