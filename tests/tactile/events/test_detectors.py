"""Shipped detectors: pulls, turns, weak and noisy contacts; alike on all backends; intervals and phases."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tactile.core.frame import Frame, Quantity, TaxelArray
from tactile.core.source import FrameStream
from tactile.events.detector_file import EventRule
from tactile.events.event import Event
from tactile.events.phases import phases
from tactile.events.tracker import Tracker
from tactile.pipeline import warm_up
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.touch.made import events, grip, stream


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
