"""Sweeps of thresholds over labelled recordings."""

from pathlib import Path

import pytest

from cnnsim.support import InputError
from cnnsim.sweep.spec import read_sweep
from tactile.cli.group import SWEEPS
from tactile.sources.convert import convert
from tactile.sweeps.labelled import check, options_of, run
from tests.kits.touch.source import SCENE

SPEC = """
kind = "labelled"
[fixed]
recordings = "grasps"
labels = "grasps/labels.csv"
[grid]
contact_level = [0.0001, 5.0]
dead_band_sigmas = { from = 3, to = 5, count = 2 }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "grasps").mkdir()
    (tmp_path / "a.toml").write_text(SCENE)
    convert(tmp_path / "a.toml", tmp_path / "grasps" / "a.npz")
    (tmp_path / "grasps" / "labels.csv").write_text("recording,sensor,contact_s\na,0,0.02\n")
    (tmp_path / "s.toml").write_text(SPEC)
    return tmp_path


def test_thresholds_decide_what_is_found(folder: Path) -> None:
    sweep = read_sweep(folder / "s.toml", SWEEPS)
    low, other, high, _ = run([sweep.case(number) for number in range(4)])
    assert (low["contact_recall"], high["contact_recall"]) == (1.0, 0.0)
    assert low["contact_hit"] == other["contact_hit"] == 1
    assert abs(low["contact_onset_ms_50"]) < 20
    assert high["contact_onset_ms_50"] is None
    assert not [name for name in low if "baseline" in name]
    assert set(low) == set(high)


def test_what_is_not_said_stays_as_it_is() -> None:
    assert options_of({"hysteresis_sigmas": 9.0}).sigmas == (4.0, 9.0, 3.0)
    assert options_of({"dead_band": 0.2}).dead_band == 0.2


def test_wrong_cases_are_refused(folder: Path) -> None:
    good = {"recordings": str(folder / "grasps"), "labels": str(folder / "grasps" / "labels.csv")}
    check(good)
    for wrong, said in (
        ({"recordings": str(folder / "none")}, "no folder"), ({"labels": str(folder / "none.csv")}, "cannot be read"),
        ({"hysteresis": 1.0}, "needs a dead_band"), ({"contact_sigmas": -1.0}, "a number from 0 wanted"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said):
            check({**good, **wrong})
