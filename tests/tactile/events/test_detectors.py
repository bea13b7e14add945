"""Shipped detectors: pulls, twists, weak and noisy contacts, releases; event intervals and phases."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tactile.core.frame import Quantity, TaxelArray
from tactile.events.detector_file import EventRule
from tactile.events.event import Event
from tactile.events.phases import phases
from tactile.events.tracker import Tracker
from tactile.pipeline import warm_up
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.touch.made import events, force_stream, grip, stream


@pytest.mark.parametrize(("along", "direction"), [((1, 0), "+x"), ((0, -1), "-y"), ((-1, 1), "-x +y")])
def test_a_pull_has_its_direction(along: tuple[int, int], direction: str) -> None:
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
def test_twists_spreads_and_pinches_are_distinguished(turn: tuple[int, int], kind: str, sense: str | None) -> None:
    """Shear (-y, x) about the middle is a clockwise twist in image coordinates, (x, y) a spread."""
    ramp = np.concatenate([np.zeros(160), np.linspace(0, 0.1, 80), np.full(60, 0.1)])
    y, x = np.mgrid[-2.5:3.5, -2.5:3.5]
    field = np.stack([turn[0] * (y if kind == "twist" else x), turn[1] * (x if kind == "twist" else y)], axis=-1)
    forces = grip(300)
    forces[:, 1:5, 1:5, :2] = (ramp[:, None, None, None] * field)[:, 1:5, 1:5]
    found = {event.kind: event for event in events(stream(forces))}
    assert kind in found
    assert not {"twist", "spread", "pinch", "pull"} & (set(found) - {kind})
    assert found[kind].data.get("sense") == sense


@pytest.mark.parametrize(("size", "load"), [(2, 0.1), (2, 1.0), (4, 0.2), (4, 0.5), (8, 0.5), (8, 1.0)])
@pytest.mark.parametrize("tare", ["auto", "off"])
def test_a_weak_contact_lasts_until_its_release(size: int, load: float, tare: str) -> None:
    """Offset and noise are updated every 0.2 s, but not during or just after a contact."""
    rng, t = np.random.default_rng(0), np.arange(440) / 200
    y, x = np.mgrid[0:size, 0:size] - (size - 1) / 2
    under = np.exp(-(x**2 + y**2) / 2 / (size / 6 + 0.3) ** 2)
    forces = rng.standard_normal((len(t), size, size, 3)) * (1.2e-3, 1.2e-3, 3.6e-3)
    ramp = load * np.clip((t - 0.5) / 0.05, 0, 1) * np.clip((1.6 - t) / 0.05, 0, 1)
    forces[..., 2] += ramp[:, None, None] * under / under.sum()
    source = force_stream(t, forces, 2e-3, untared=False)
    found = [event for event in events(source, tare=tare) if event.kind in ("contact", "release")]
    assert [event.kind for event in found] == ["contact", "release"]
    assert found[0].t == pytest.approx(0.52, abs=0.03)  # it starts at 0.5 s
    assert found[1].t == pytest.approx(1.59, abs=0.025)


@pytest.mark.parametrize("quantity", ["force", "strain", "stress"])
def test_the_warm_up_produces_every_kind_of_event(quantity: Quantity) -> None:
    depth, modulus = (0.0, None) if quantity == "force" else (2e-3, 2.4e6)
    arrays = tuple(TaxelArray(name, 4, 4, 2e-3, depth, quantity=quantity) for name in ("left", "right"))
    found: list[Event] = []
    warm_up(arrays, modulus, Settings(), [lambda report: found.extend(report.events)])
    wanted = {"contact", "load", "hold", "tangential_load", "pull", "release"} | ({"slip"} if depth else set())
    for finger in ("left", "right"):
        assert {event.kind for event in found if event.finger == finger} >= wanted


def test_a_contact_ends_at_the_knee_above_a_residual_load() -> None:
    """After the release, creep or an offset leaves an eighth of the load."""
    fall = 1 / 8 + 7 / 8 * np.exp(-np.arange(40) / 200 / 0.02)
    scale = np.concatenate([np.ones(160), fall, np.full(160, 1 / 8)])
    forces = grip(len(scale)) * scale[:, None, None, None]
    (end,) = (event for event in events(stream(forces)) if event.kind == "release")
    assert end.t == pytest.approx(0.5 + 160 / 200 + 0.1, abs=0.04)


def test_idle_noise_and_one_noisy_taxel_make_no_events() -> None:
    source = stream(np.zeros((1000, 6, 6, 3)))
    rng = np.random.default_rng(2)
    for frame in source.stream:
        frame.values[2, 3] = 0.05 * rng.standard_normal(3)
    assert events(source, tare="auto") == []


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_a_release_of_sheared_skin_is_no_pull(tmp_path: Path, quantity: str) -> None:
    """A pull ends with the grip: shear falls to 0 by more than the threshold, but without contact."""
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
    (release,) = (event.t for event in found if event.kind == "release")
    pulls = [event for event in found if event.kind in ("tangential_load", "pull")]
    assert [event.data["direction"] for event in pulls] == ["+x", "+x +y"]
    assert all(event.t < release and event.end is not None and event.end < release + 0.01 for event in pulls)


def test_frames_without_valid_readings_end_no_event() -> None:
    source = stream(grip(200))
    for n in (150, 220, 221, 222):
        source.stream[n].values[:] = np.nan  # type: ignore[index]  # a list
        source.stream[n].valid[:] = False  # type: ignore[index]  # the same
    plain, broken = ([(e.kind, e.t, e.end) for e in events(one)] for one in (stream(grip(200)), source))
    assert [kind for kind, *_ in broken] == [kind for kind, *_ in plain] == ["contact", "load", "hold"]
    assert all(one[1:] == other[1:] for one, other in zip(plain, broken, strict=True))


@pytest.mark.parametrize(("rule", "on", "unless", "expected"), [
    (EventRule("x", "w", "x", confirm=0.02, release=0.03), (0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0), (0,) * 13,
     [("begins", 0.03, None, 5), ("ends", 0.03, 0.09, 12)]),
    (EventRule("x", "w", "x", confirm=0.03, unless="v"), (1, 0, 0, 1, 1, 0, 0, 0), (0, 1, 0, 0, 0, 0, 0, 0),
     [("begins", 0.03, 0.05, 6), ("ends", 0.03, 0.05, 7)]),
])  # fmt: skip
def test_an_interval_starts_when_first_on_and_ends_when_first_off(
    rule: EventRule, on: tuple[int, ...], unless: tuple[int, ...], expected: list[tuple[object, ...]]
) -> None:
    """Frames of 10 ms; with ``unless``, the output need not stay on until confirmation."""
    tracker, changes = Tracker(rule), []
    for n, (black, cancelled) in enumerate(zip(on, unless, strict=True)):
        change = tracker.update(n / 100, bool(black), bool(cancelled))
        if change is not None:
            changes.append((change, tracker.onset, tracker.end, n))
    assert changes == expected


def test_phases_cover_the_time_without_gaps() -> None:
    found = events(stream(np.concatenate([grip(200), np.zeros((60, 6, 6, 3))])))
    tiles = phases(found, "pad", 0.0, 1.8)
    assert [tile.phase for tile in tiles][:3] == ["approach", "load", "hold"]
    assert all(one.end == other.start for one, other in pairwise(tiles))
    assert (tiles[0].start, tiles[-1].end) == (0.0, 1.8)
