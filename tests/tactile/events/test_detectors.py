"""Detectors: files of users beside the shipped ones, alike on all backends and roads; intervals, votes and noise."""

import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import InputError
from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.core.source import FrameStream, Source
from tactile.events.detector_file import EventRule, read_detector, shipped_detectors, users_detectors
from tactile.events.event import Event, EventLog
from tactile.events.phases import phases
from tactile.events.registry import SHIPPED
from tactile.events.tracker import Tracker
from tactile.pipeline import run, warm_up
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.paths import ROOT
from tests.kits.serial import call

PAD = TaxelArray("pad", 6, 6, 3e-3, 0.0, quantity="force")
PAGE = (ROOT / "docs" / "detectors.md").read_text(encoding="utf-8")
TWO_BLOBS = re.findall(r"```toml\n(.*?)```", PAGE, re.S)[0]


def stream(forces: np.ndarray, rate: float = 200.0, noise: float = 2e-3, seed: int = 1) -> FrameStream:
    """Frames (n, 6, 6, 3) after half a second of nothing, with noise."""
    quiet = np.zeros((round(rate / 2), *forces.shape[1:]))
    values = np.concatenate([quiet, forces]) + noise * np.random.default_rng(seed).standard_normal(
        (len(quiet) + len(forces), *forces.shape[1:])
    )
    frames = [Frame(0, n / rate, n, one, np.ones(PAD.shape, bool)) for n, one in enumerate(values)]
    return FrameStream("made", (PAD,), None, len(frames), frames)


def events(source: Source, **settings: Any) -> list[Event]:
    log = EventLog()
    run(source, Settings(**settings), [lambda report: log.add(report.events, report.ended)])
    return log.events


def patch(frames: int, rows: slice, cols: slice, force: tuple[float, float, float]) -> np.ndarray:
    out = np.zeros((frames, 6, 6, 3))
    out[:, rows, cols] = force
    return out


def grip(frames: int = 200) -> np.ndarray:
    return patch(frames, slice(1, 5), slice(1, 5), (0.0, 0.0, 0.5))


def two_blobs(tmp_path: Path) -> Path:
    path = tmp_path / "two-blobs.toml"
    path.write_text(TWO_BLOBS, encoding="utf-8")
    return path


def test_the_detector_on_the_page_runs_on_recordings(tmp_path: Path) -> None:
    one, other = (patch(100, slice(0, 2), slice(n, n + 2), (0, 0, 0.5)) for n in (0, 4))
    source = stream(np.concatenate([one, one + other, one, np.zeros_like(one)]))
    said: list[float] = []
    programs = (str(two_blobs(tmp_path)),)
    run(source, Settings(programs=programs), [lambda report: said.extend([report.frame.t] * len(report.said))])
    assert 4 <= len(said) <= 12  # of 500 frames: where its outputs change
    (event,) = (found for found in events(source, programs=programs) if found.kind == "two_blobs")
    assert (event.t, event.end) == pytest.approx((1.0, 1.5), abs=0.006)
    assert event.told - event.t >= 0.02
    assert event.words == "separate contacts on 8 taxels"
    assert len(event.taxels) == 8


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
    (('"two_blobs"', '"Two blobs"'), "small letters"),
    (("{taxels}", "{taxel}"), "words name taxel"),
    (("{taxels}", "{length_mm}"), "words name length_mm; of direction, sense, taxels, of_taxels"),
    (("confirm_ms = 20", 'lag_of = "touch"'), "lag_of = 'touch'; one of yielding, drawn wanted"),
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
        ((path, path), "there is a program 'two-blobs' already"),
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


@pytest.mark.parametrize(("along", "direction"), [((1, 0), "+x"), ((0, -1), "-y"), ((-1, 1), "-x +y")])
def test_a_pull_in_a_hold_has_its_direction(along: tuple[int, int], direction: str) -> None:
    ramp = np.concatenate([np.zeros(160), np.linspace(0, 0.2, 80), np.full(60, 0.2)])
    forces = grip(300)
    forces[:, 1:5, 1:5, :2] = ramp[:, None, None, None] * along
    found = {event.kind: event for event in events(stream(forces))}
    assert found["tangential_load"].t == pytest.approx(0.5 + 160 / 200, abs=0.06)
    assert found["tangential_load"].data["direction"] == direction
    assert "twist" not in found


@pytest.mark.parametrize(("turn", "kind", "sense"), [
    ((-1, 1), "twist", "clockwise"), ((1, -1), "twist", "anticlockwise"), ((1, 1), "spread", None),
    ((-1, -1), "pinch", None),
])  # fmt: skip
def test_turns_and_spreads_are_told_apart(turn: tuple[int, int], kind: str, sense: str | None) -> None:
    """Shear (-y, x) about the middle is a clockwise turn as seen in the picture, (x, y) a spread."""
    ramp = np.concatenate([np.zeros(160), np.linspace(0, 0.1, 80), np.full(60, 0.1)])
    y, x = np.mgrid[-2.5:3.5, -2.5:3.5]
    field = np.stack([turn[0] * (y if kind == "twist" else x), turn[1] * (x if kind == "twist" else y)], axis=-1)
    forces = grip(300)
    forces[:, 1:5, 1:5, :2] = (ramp[:, None, None, None] * field)[:, 1:5, 1:5]
    found = {event.kind: event for event in events(stream(forces))}
    assert kind in found
    assert not {"twist", "spread", "pinch", "pull"} & (set(found) - {kind})
    assert found[kind].data.get("sense") == sense


@pytest.mark.parametrize("backend", ["reference", "opencl"])
def test_events_are_the_same_on_every_backend(backend: str) -> None:
    if backend == "opencl":
        pytest.importorskip("pyopencl")
    forces = grip(120)
    forces[80:, 1:5, 1:5, 0] = np.linspace(0, 0.2, 40)[:, None, None]
    plain, other = (
        [(e.t, e.end, e.kind, e.words, e.taxels) for e in events(stream(forces), backend=name)]
        for name in ("cpu", backend)
    )
    assert plain == other
    assert len(plain) >= 3


@pytest.mark.parametrize(("size", "load"), [(2, 0.1), (2, 1.0), (4, 0.2), (4, 0.5), (8, 0.5), (8, 1.0)])
@pytest.mark.parametrize("tare", ["auto", "off"])
def test_a_weak_contact_lasts_until_it_is_over(size: int, load: float, tare: str) -> None:
    """Offset and noise are renewed every 0.2 s, but not while, or just after, something touches."""
    rng, t = np.random.default_rng(0), np.arange(440) / 200
    y, x = np.mgrid[0:size, 0:size] - (size - 1) / 2
    under = np.exp(-(x**2 + y**2) / 2 / (size / 6 + 0.3) ** 2)
    forces = rng.standard_normal((len(t), size, size, 3)) * (1.2e-3, 1.2e-3, 3.6e-3)
    ramp = load * np.clip((t - 0.5) / 0.05, 0, 1) * np.clip((1.6 - t) / 0.05, 0, 1)
    forces[..., 2] += ramp[:, None, None] * under / under.sum()
    pad, every = TaxelArray("pad", size, size, 2e-3, 0.0, quantity="force"), np.ones((size, size), bool)
    frames = [Frame(0, time, n, one, every) for n, (time, one) in enumerate(zip(t.tolist(), forces, strict=True))]
    found = [e for e in events(FrameStream("weak", (pad,), None, len(frames), frames), tare=tare)
             if e.kind in ("contact", "release")]  # fmt: skip
    assert [event.kind for event in found] == ["contact", "release"]
    assert found[0].t == pytest.approx(0.52, abs=0.03)  # it begins at 0.5
    assert found[1].t == pytest.approx(1.59, abs=0.025)


@pytest.mark.parametrize("quantity", ["force", "strain", "stress"])
def test_the_warm_up_goes_through_contact_load_hold_pull_slip_and_release(quantity: Quantity) -> None:
    depth, modulus = (0.0, None) if quantity == "force" else (2e-3, 2.4e6)
    arrays = tuple(TaxelArray(name, 4, 4, 2e-3, depth, quantity=quantity) for name in ("left", "right"))
    told: list[Event] = []
    warm_up(arrays, modulus, Settings(), [lambda report: told.extend(report.events)])
    wanted = {"contact", "load", "hold", "tangential_load", "pull", "release"} | ({"slip"} if depth else set())
    for finger in ("left", "right"):
        assert {event.kind for event in told if event.finger == finger} >= wanted


def test_a_contact_ends_at_the_knee_above_a_tail_of_an_eighth() -> None:
    """Silicone that creeps, and a taxel that an overshoot has left shifted: an eighth of the load stays."""
    fall = 1 / 8 + 7 / 8 * np.exp(-np.arange(40) / 200 / 0.02)
    scale = np.concatenate([np.ones(160), fall, np.full(160, 1 / 8)])
    forces = grip(len(scale)) * scale[:, None, None, None]
    (end,) = (event for event in events(stream(forces)) if event.kind == "release")
    assert end.t == pytest.approx(0.5 + 160 / 200 + 0.1, abs=0.04)


def test_idle_noise_is_nothing_and_one_noisy_taxel_too() -> None:
    source = stream(np.zeros((1000, 6, 6, 3)))
    rng = np.random.default_rng(2)
    for frame in source.stream:
        frame.values[2, 3] = 0.05 * rng.standard_normal(3)
    assert events(source, tare="auto") == []


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_nothing_is_pulled_once_the_finger_is_released(tmp_path: Path, quantity: str) -> None:
    """A pull that goes off with the grip: shear falls to 0 by as much as would be a load, but nothing touches."""
    path = tmp_path / "let-go.toml"
    path.write_text(
        'title = "let go"\nrate_hz = 200\nduration_s = 2.2\n[cover]\nyoungs_modulus_mpa = 2.4\n'
        f'quantity = "{quantity}"\n[[finger]]\nname = "tip"\nrows = 3\ncols = 5\npitch_mm = 1.0\ndepth_mm = 1.0\n'
        '[[load]]\nfinger = "tip"\npath = ['
        "[0.3, 0.5, -0.4, 0, 0, 0], [0.5, 0.5, -0.4, 0, 0, 0.2], [1, 0.5, -0.4, 0, 0, 0.2],"
        "[1.3, 0.5, -0.4, 0.12, 0.03, 0.2], [1.6, 0.5, -0.4, 0.12, 0.03, 0.2], [1.8, 0.5, -0.4, 0, 0, 0]]\n",
        encoding="utf-8",
    )
    found = events(open_source(path))
    (let_go,) = (event.t for event in found if event.kind == "release")
    pulls = [event for event in found if event.kind in ("tangential_load", "pull")]
    assert [event.data["direction"] for event in pulls] == ["+x", "+x +y"]
    assert all(event.t < let_go and event.end is not None and event.end < let_go + 0.01 for event in pulls)


def test_a_frame_that_no_taxel_read_ends_nothing() -> None:
    source = stream(grip(200))
    for n in (150, 220, 221, 222):
        source.stream[n].values[:] = np.nan  # type: ignore[index]  # a list
        source.stream[n].valid[:] = False  # type: ignore[index]  # the same
    plain, broken = ([(e.kind, e.t, e.end) for e in events(one)] for one in (stream(grip(200)), source))
    assert [kind for kind, *_ in broken] == [kind for kind, *_ in plain] == ["contact", "load", "hold"]
    assert all(one[1:] == other[1:] for one, other in zip(plain, broken, strict=True))


def test_a_shipped_detector_is_a_file_that_users_can_read() -> None:
    found = shipped_detectors(SHIPPED)
    kinds = {rule.kind for detector in found for rule in detector.rules}
    assert kinds == {
        "contact", "release", "load", "hold", "tangential_load", "pull", "twist", "spread", "pinch", "slip",
        "incipient_slip",
    }  # fmt: skip


def test_an_interval_begins_where_it_was_first_on_and_ends_where_it_was_first_off() -> None:
    tracker = Tracker(EventRule("x", "w", "x", confirm=0.02, release=0.03))
    turns = []
    for n, on in enumerate([0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0]):
        turn = tracker.update(n / 100, bool(on))
        if turn is not None:
            turns.append((turn, tracker.onset, tracker.end, n))
    assert turns == [("begins", 0.03, None, 5), ("ends", 0.03, 0.09, 12)]


def test_phases_tile_the_time() -> None:
    found = events(stream(np.concatenate([grip(200), np.zeros((60, 6, 6, 3))])))
    tiles = phases(found, "pad", 0.0, 1.8)
    assert [tile.phase for tile in tiles][:3] == ["approach", "load", "hold"]
    assert all(one.end == other.start for one, other in pairwise(tiles))
    assert (tiles[0].start, tiles[-1].end) == (0.0, 1.8)


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
    for what in ("did you mean 'when'", "small letters", "did you mean 'summary'", "'toch' is not declared"):
        assert what in str(raised.value)
    assert str(raised.value).count(path.name) == 1
