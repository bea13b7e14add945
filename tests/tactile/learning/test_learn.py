"""Learned detectors: onsets by the rules of the tracker, files that compute the fitted drive, fits, refused input."""

from pathlib import Path

import numpy as np
import pytest

from cnnsim import UniversalMachine
from tactile.events.detector_file import EventRule, read_detector
from tactile.events.tracker import Tracker
from tactile.learning.collect import Example
from tactile.learning.detector import detector_text
from tactile.learning.fit import RELEASE, Learned, around, begins, fit
from tactile.learning.front import Front, front_of
from tactile.learning.trial import folds
from tactile.sources.replay_npz import write_npz
from tests.kits.serial import call
from tests.kits.touch.made import force_stream


@pytest.mark.parametrize("confirm", [0.0, 0.03])
def test_onsets_are_those_of_the_tracker(confirm: float) -> None:
    rng, t = np.random.default_rng(4), np.arange(3000) / 100
    on = np.repeat(rng.random(300) < 0.3, 10) ^ (rng.random(3000) < 0.02)
    tracker, wanted = Tracker(EventRule("one", "on", "", confirm=confirm, release=RELEASE)), []
    for time, now in zip(t.tolist(), on, strict=True):
        turn = tracker.update(time, bool(now))
        wanted += [tracker.onset] if turn == "begins" else []
        if turn == "ends":
            tracker.onset = tracker.end = None  # as `Detector` does
    assert len(wanted) > 20
    assert begins(t, on, confirm) == wanted


def example(name: str, known: float | None, seed: int) -> Example:
    """Return 2 s of a touched array; the event: `driven` is black and `sticking` is not."""
    rng, t = np.random.default_rng(seed), np.arange(400) / 200
    driven = np.repeat(rng.random(10) < 0.5, 40)
    sticking = driven.copy()
    if known is not None:
        driven[t >= known], sticking[t >= known] = True, False
    other = rng.random(400) < 0.5
    planes = np.where(np.array([driven, sticking, other]), 1.0, -1.0)[..., None, None] * np.ones((3, 400, 3, 4))
    touch = np.zeros((400, 3, 4), bool)
    touch[40:, 1:, :3] = True
    size = 4 if seed % 2 else 3
    times = () if known is None else (known,)
    return Example(
        name, "pad", f"pad {size}", t, planes.transpose(1, 0, 2, 3)[..., :size], touch[..., :size], times, 2.0
    )


EXAMPLES = [example(f"grasp {n}", None if n % 3 == 0 else 0.8 + 0.1 * n, n) for n in range(9)]
PLANES = Front(("driven", "sticking", "rising"), ())


def test_a_detector_is_learned_with_few_weights_and_tells_unseen_recordings() -> None:
    learned = fit(EXAMPLES, PLANES, 2, 0.2)
    assert set(learned.front.planes) == {"driven", "sticking"}
    assert np.count_nonzero(learned.weights) == 2
    unseen = [example("unseen", 1.0, 50), example("unseen", None, 51), example("unseen", 1.4, 52)]
    found = learned.tally(unseen, [learned.drive(one, PLANES.names) for one in unseen])
    assert (found.hit, found.false, found.missed) == (2, 0, 0)
    assert found.errors == pytest.approx([0, 0], abs=0.006)


def test_parts_hold_out_each_recording_and_each_array_once() -> None:
    by_recording, by_array = folds(EXAMPLES, "recording"), folds(EXAMPLES, "array")
    for parts in (by_recording, by_array):
        assert sorted(n for part in parts for n in part) == list(range(9))
    assert len(by_recording) == 4
    assert all(any(EXAMPLES[n].known for n in part) for part in by_recording)
    assert {frozenset(EXAMPLES[n].array for n in part) for part in by_array} == {
        frozenset({"pad 3"}),
        frozenset({"pad 4"}),
    }
    assert folds(EXAMPLES[:1], "recording") == []


@pytest.mark.parametrize("most", [False, True])
def test_the_file_computes_the_fitted_drive_and_keeps_planes(most: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    front = Front(("share", "driven"), ("full",))
    learned = Learned(front, np.array([[3.0, -1.0], [-2.0, 0.0], [5.0, 1.0]]), 1.5, most, 0.02, 0.004)
    path = tmp_path / "mine.toml"
    path.write_text(detector_text(learned, "mine", "learned_slip", "nothing"))
    detector = read_detector(path)
    rule = detector.rules[0]
    assert (rule.kind, rule.when, rule.taxels) == ("learned_slip", "on", "black")
    assert (rule.confirm, rule.lag) == pytest.approx((0.02, 0.004))
    machine, was = UniversalMachine("cpu", "float64"), np.zeros((4, 5), bool)
    both = set()
    for _ in range(30):
        share = rng.uniform(-1, 1, (4, 5))
        black = rng.random((3, 4, 5)) < np.array([0.5, 0.2, 0.7])[:, None, None]
        driven, full, touch = np.where(black, 1.0, -1.0)
        out = machine.run(detector.program, share=share, driven=driven, full=full, touch=touch)
        was = (was | (full > 0)) & (touch > 0)
        planes = np.array([share, driven, np.where(was, 1.0, -1.0)])
        drive = np.tensordot(learned.weights[:, 0], planes, 1) + np.tensordot(learned.weights[:, 1], around(planes), 1)
        black = (drive + learned.z > 0) & (touch > 0)
        assert np.array_equal(out["black"], black)
        assert bool(out["on"]) == (2 * black.sum() > (touch > 0).sum() if most else black.any())
        both.add(bool(out["on"]))
    assert both == {True, False}


def test_planes_without_a_direction_are_read_by_default() -> None:
    names = front_of().names
    assert {"driven", "share", "driven_was"} <= {*names}
    assert not {"shear_x", "left", "load_q", "touch_was"} & {*names}


LABELS = "recording,sensor,contact_s,gross_slip_s\ngrasp,0,0.3,{}\n"


@pytest.mark.parametrize(
    ("slip", "options", "message"),
    [
        ("", (), "no time of a slip in the labels of 1 recordings; one or more wanted"),
        ("0.9", (), "grasp, finger 'pad', 0.050 s: readings are missing or no numbers; complete frames wanted"),
        ("", ("--planes", "wind"), "plane 'wind'"),
        ("0.9", ("--perturb", "tempo"), "groups without tempo wanted"),
        ("0.9\nother,0,0.3,0.8", (), "no recording of the labels other; all of them wanted"),
        ("NaN", (), "line 2: gross_slip_s = nan; finite times wanted"),
        ("0.9", ("--labels", "no.csv"), "no.csv"),
    ],
)
def test_wrong_input_is_one_line(
    slip: str, options: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    values = np.zeros((200, 2, 2, 3))
    values[10, 0, 0, 0] = np.nan
    write_npz(Path("r") / "grasp.npz", force_stream(np.arange(200) / 200, values))
    Path("l.csv").write_text(LABELS.format(slip))
    result = call("learn", "r", "--labels", "l.csv", "--kind", "slip", *options)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert message in result.stderr
