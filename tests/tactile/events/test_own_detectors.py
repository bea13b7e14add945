"""Detectors as files: those that users write, and what is wrong in them."""

import json
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
from tests.kits.serial import call
from tests.kits.touch.made import events, grip, patch, stream

PAGE = (ROOT / "docs" / "detectors.md").read_text(encoding="utf-8")
TWO_BLOBS = re.findall(r"```toml\n(.*?)```", PAGE, re.S)[0]


def two_blobs(tmp_path: Path) -> Path:
    path = tmp_path / "two-blobs.toml"
    path.write_text(TWO_BLOBS, encoding="utf-8")
    return path


def test_the_detector_on_the_page_runs_on_recordings(tmp_path: Path) -> None:
    one, other = (patch(100, slice(0, 2), slice(n, n + 2), (0, 0, 0.5)) for n in (0, 4))
    source = stream(np.concatenate([one, one + other, one, np.zeros_like(one)]))
    said: list[float] = []
    programs = (str(two_blobs(tmp_path)),)
    run(source, Settings(programs=programs), [lambda report: said.extend([report.frame.t] * len(report.outputs))])
    assert 4 <= len(said) <= 12  # of 500 frames: where its outputs change
    (event,) = (found for found in events(source, programs=programs) if found.kind == "two_blobs")
    assert (event.t, event.end) == pytest.approx((1.0, 1.5), abs=0.006)
    assert event.told - event.t >= 0.02
    assert event.words == "separate contacts on 8 taxels"
    assert len(event.taxels) == 8


def test_the_first_kind_of_an_event_begins_where_that_began(tmp_path: Path) -> None:
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


def test_the_detector_on_the_page_runs_on_a_scene(tmp_path: Path) -> None:
    loads = "".join(
        f'[[load]]\nfinger = "tip"\npath = [[0.5, {x}, 0, 0, 0, 0], [0.6, {x}, 0, 0, 0, 0.3], [1.2, {x}, 0, 0, 0, 0.3]]'
        "\n"
        for x in (-3, 3)
    )
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'title = "two"\nrate_hz = 100\nduration_s = 1.5\n[cover]\nyoungs_modulus_mpa = 2.4\n[[finger]]\nname = "tip"\n'
        f"rows = 8\ncols = 8\npitch_mm = 1.0\ndepth_mm = 1.0\n{loads}",
        encoding="utf-8",
    )
    result = call("run", scene, "--program", two_blobs(tmp_path), "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "separate contacts on" in result.stdout
    record = json.loads((tmp_path / "out" / "events.json").read_text(encoding="utf-8"))
    assert "two_blobs" in [event["kind"] for event in record["events"]]


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


OWN_NAMES = """
name    = "own-names"
summary = "Calls its planes as the shipped detectors call theirs, and says the contrary."
llm     = ["touch", "contact", "right", "left", "moved", "unsteady"]
wire    = ["in_contact", "slides"]
inputs  = ["touch"]
outputs = ["contact", "right", "left", "moved", "unsteady", "in_contact", "slides"]
step = [
  { logic = "not-p", of = "touch", to = "contact" },
  { logic = "black", of = "touch", to = "right" },
  { logic = "black", of = "touch", to = "left" },
  { logic = "black", of = "touch", to = "moved" },
  { logic = "black", of = "touch", to = "unsteady" },
  { fill = 1, to = "in_contact" },
  { fill = 1, to = "slides" },
]
"""


def test_what_a_user_calls_his_planes_changes_no_event_of_the_shipped_detectors(tmp_path: Path) -> None:
    path = tmp_path / "own-names.toml"
    path.write_text(OWN_NAMES, encoding="utf-8")
    forces = np.concatenate([grip(200), np.zeros((60, 6, 6, 3))])
    forces[160:200, 1:5, 1:5, 0] = np.linspace(0, 0.2, 40)[:, None, None]
    plain, beside = (
        [(e.t, e.end, e.kind, e.words, e.taxels) for e in events(stream(forces), programs=programs)]
        for programs in ((), (str(path),))
    )
    assert plain == beside
    assert {kind for _, _, kind, _, _ in plain} >= {"contact", "hold", "tangential_load", "release"}


def test_a_kind_is_made_by_one_detector_and_a_program_runs_once(tmp_path: Path) -> None:
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
def test_words_close_over_data_that_are_not_known(text: str, words: str) -> None:
    event = Event(0.0, "pad", 0, "edge", {"taxels": 3}, text, "", "", 0, 0.0, None)
    assert event.words == words


def test_a_shipped_detector_is_a_file_that_users_can_read() -> None:
    found = shipped_detectors(SHIPPED)
    kinds = {rule.kind for detector in found for rule in detector.rules}
    assert kinds == {
        "contact", "release", "load", "hold", "tangential_load", "pull", "twist", "spread", "pinch", "slip",
        "incipient_slip",
    }  # fmt: skip


def test_all_that_is_wrong_in_a_detector_is_told_at_once(tmp_path: Path) -> None:
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
