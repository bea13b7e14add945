"""Detector files written by users, and errors in them."""

import re
from pathlib import Path

import numpy as np
import pytest

from cnnsim import InputError
from tactile.events.detector_file import SHIPPED, read_detector, shipped_detectors, users_detectors
from tactile.events.event import Event
from tactile.pipeline import run
from tactile.settings import Settings
from tests.kits.paths import ROOT
from tests.kits.touch.made import events, patch, stream

PAGE = (ROOT / "docs" / "detectors.md").read_text(encoding="utf-8")
TWO_BLOBS = re.findall(r"```toml\n(.*?)```", PAGE, re.S)[0]


def two_blobs(tmp_path: Path) -> Path:
    path = tmp_path / "two-blobs.toml"
    path.write_text(TWO_BLOBS, encoding="utf-8")
    return path


def test_the_documented_detector_runs_on_frames(tmp_path: Path) -> None:
    one, other = (patch(100, slice(0, 2), slice(n, n + 2), (0, 0, 0.5)) for n in (0, 4))
    source = stream(np.concatenate([one, one + other, one, np.zeros_like(one)]))
    times: list[float] = []
    programs = (str(two_blobs(tmp_path)),)
    run(source, Settings(programs=programs), [lambda report: times.extend([report.frame.t] * len(report.outputs))])
    assert 4 <= len(times) <= 12  # of 500 frames, those with changed outputs
    (event,) = (found for found in events(source, programs=programs) if found.kind == "two_blobs")
    assert (event.t, event.end) == pytest.approx((1.0, 1.5), abs=0.006)
    assert event.told - event.t >= 0.02
    assert event.words == "separate contacts on 8 taxels"
    assert len(event.taxels) == 8


def test_the_first_event_of_a_kind_takes_the_onset_of_its_kind(tmp_path: Path) -> None:
    one, other = (patch(100, slice(0, 2), slice(n, n + 2), (0, 0, 0.5)) for n in (0, 4))
    path = two_blobs(tmp_path)
    whole = '[[event]]\nkind = "touched"\nwhen = "touch"\n\n[[event]]\nkind_of = "touched"\n'
    path.write_text(TWO_BLOBS.replace("[[event]]\n", whole), encoding="utf-8")
    frames = np.concatenate([np.zeros_like(one), one, one + other, one, one + other, np.zeros_like(one)])
    found = events(stream(frames), programs=(str(path),))
    (touched,) = (event for event in found if event.kind == "touched")
    first, second = (event for event in found if event.kind == "two_blobs")
    assert first.t == touched.t == pytest.approx(1.0, abs=0.006)
    assert first.told == pytest.approx(1.52, abs=0.01)
    assert second.t == pytest.approx(2.5, abs=0.006)


@pytest.mark.parametrize(("change", "message"), [
    (('when       = "several"', 'when = "many"'), "event 'two_blobs': many; of the outputs touch, blobs, several"),
    (('inputs  = ["touch"]', 'inputs  = ["toch"]'), "toch"),
    (('"two_blobs"', '"Two blobs"'), "lower-case letters"),
    (("{taxels}", "{taxel}"), "words name taxel"),
    (("{taxels}", "{length_mm}"), "words name length_mm; of direction, sense, taxels, of_taxels"),
    (("confirm_ms = 20", 'lag_of = "touch"'), "lag_of = 'touch'; one of yielding, drawn wanted"),
    (("confirm_ms = 20", 'kind_of = "touch"'), "kind_of = 'touch'; an earlier event of the file wanted, of none"),
    (("confirm_ms", "confirms_ms"), "did you mean 'confirm_ms'"),
])  # fmt: skip
def test_wrong_detectors_are_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = two_blobs(tmp_path)
    path.write_text(TWO_BLOBS.replace(*change), encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(message)):
        read_detector(path)


def test_duplicate_kinds_and_programs_are_refused(tmp_path: Path) -> None:
    path = two_blobs(tmp_path)
    other, third = tmp_path / "other.toml", tmp_path / "third.toml"
    renamed = TWO_BLOBS.replace('"two-blobs"', '"other"')
    other.write_text(renamed.replace('"two_blobs"', '"contact"'), encoding="utf-8")
    third.write_text(renamed, encoding="utf-8")
    for programs, message in (
        ((path, path), "a program 'two-blobs' is given already"),
        ((other,), "kind 'contact' is made by the shipped 'contact'"),
        ((path, third), "kind 'two_blobs' is made by 'two-blobs'"),
    ):
        with pytest.raises(InputError, match=re.escape(message)):
            users_detectors([str(one) for one in programs])


@pytest.mark.parametrize(("text", "words"), [
    ("edge {direction}, {taxels} taxels", "edge, 3 taxels"), ("tap, {force_n}, {direction}, {taxels}", "tap, 3"),
    ("{direction}: {taxels}", "3"),
])  # fmt: skip
def test_words_omit_unknown_data(text: str, words: str) -> None:
    event = Event(0.0, "pad", 0, "edge", {"taxels": 3}, text, "", "", 0, 0.0, None)
    assert event.words == words


def test_the_shipped_detectors_define_all_kinds() -> None:
    found = shipped_detectors(SHIPPED)
    kinds = {rule.kind for detector in found for rule in detector.rules}
    assert kinds == {
        "contact", "release", "load", "hold", "tangential_load", "pull", "twist", "spread", "pinch", "slip",
        "incipient_slip",
    }  # fmt: skip


def test_all_faults_of_a_detector_are_reported_together(tmp_path: Path) -> None:
    path, text = two_blobs(tmp_path), TWO_BLOBS
    for change in (
        ('"two_blobs"', '"Two blobs"'), ("summary", "sumary"), ('inputs  = ["touch"]', 'inputs  = ["toch"]'),
        ("[[event]]", '[[event]]\nkind = "other"\nwen = "several"\n\n[[event]]'),
    ):  # fmt: skip
        text = text.replace(*change)
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        read_detector(path)
    for what in ("did you mean 'when'", "lower-case letters", "did you mean 'summary'", "'toch' is not declared"):
        assert what in str(raised.value)
    assert str(raised.value).count(path.name) == 1
