"""Onset of tangential loads: bend of a known course, weak pulls, real recordings at other tempos and gains."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.events.signals.onset_numba import KEPT, bend, remember
from tactile.sources import open_source
from tests.kits.paths import DATA
from tests.kits.touch.made import events, force_stream

REAL = DATA / "papillarray"
ONSETS = {"rigid_obj_slide_23-08-23": 1.10, "rigid_obj_moment_23-06-07": 0.95}


def untared(arrays: tuple[TaxelArray, ...], frames: list[Frame]) -> FrameStream:
    return FrameStream("", arrays, None, len(frames), frames, Provenance(untared=True))


@pytest.mark.parametrize("since", [0.06, 0.15, 0.22])
def test_the_bend_of_a_drifting_course_is_found(since: float) -> None:
    times, past, state = np.zeros(KEPT), np.zeros((KEPT, 1, 2, 3)), np.zeros(2, np.int64)
    rng, now = np.random.default_rng(3), 1.0
    for t in np.arange(0.0, now, 0.005):
        course = 0.2 - 0.05 * t + 0.8 * max(t - (now - since), 0.0) + 1e-3 * rng.standard_normal()
        remember(t, np.array([[[-course, 0.0, 4.0], [0.0, 9.0, 4.0]]]), times, past, state)
    drawn = np.array([[[-0.3, 0.1]], [[0.0, 0.0]]])  # the second taxel has no shear direction
    scratch = np.zeros((2, KEPT)), np.zeros((KEPT, KEPT))
    found = bend(now, drawn, past[0], False, times, past, state, *scratch)
    assert found == pytest.approx(now - since, abs=0.008)
    state[:] = 0
    assert bend(now, drawn, past[0], False, times, past, state, *scratch) == now


def test_a_weak_pull_is_detected_from_all_taxels_together() -> None:
    """0.9 N in 0.6 s over nine taxels, 0.17 N/s each, with noise of 15 mN: one taxel takes 0.4 s to 9 sigma."""
    rng = np.random.default_rng(11)
    t = np.arange(0.0, 3.2, 0.002)
    force = 4.5 * np.interp(t, [0.6, 0.7, 3.0, 3.1], [0, 1, 1, 0])
    pull = 0.9 * np.clip((t - 2.0) / 0.6, 0, 1) * (force > 0)
    values = np.stack([0.8 * pull, -0.6 * pull, force], -1)[:, None, None] / 9 * np.ones((1, 3, 3, 1))
    values += 0.015 * rng.standard_normal(values.shape)
    pulls = [event for event in events(force_stream(t, values), tare="auto") if event.kind == "tangential_load"]
    assert [event.data["direction"] for event in pulls] == ["+x -y"]
    assert pulls[0].t == pytest.approx(2.0, abs=0.03)
    assert pulls[0].told < 2.2


@pytest.mark.skipif(not REAL.exists(), reason="the papillarray recordings are not available")
@pytest.mark.parametrize("tempo", [0.5, 0.6, 2.0])
@pytest.mark.parametrize("name", ONSETS)
def test_the_onset_is_found_at_any_tempo(name: str, tempo: float) -> None:
    """Relaxation of the grip before the pull is no onset, and no part of the slide is a twist."""
    source, until = open_source(REAL / f"{name}.npz"), 3.4 if tempo > 1 else 1.5
    frames = [replace(frame, t=tempo * frame.t) for frame in source if frame.finger == 0 and frame.t < until]
    found = events(untared(source.arrays[:1], frames), tare="auto")
    first = [event.t for event in found if event.kind == "tangential_load"]
    assert first
    assert first[0] == pytest.approx(tempo * ONSETS[name], abs=0.06)
    turns = [event.data["sense"] for event in found if event.kind == "twist"]
    assert turns[:1] == (["clockwise"] if "moment" in name else [])


@pytest.mark.skipif(not REAL.exists(), reason="the papillarray recordings are not available")
@pytest.mark.parametrize(("dead", "shear"), [(0, 1.0), (4, 1.0), (None, 1.5)])
def test_the_onset_is_found_with_a_dead_taxel_or_more_shear(dead: int | None, shear: float) -> None:
    source, name = open_source(REAL / "rigid_obj_slide_23-08-23.npz"), "rigid_obj_slide_23-08-23"
    frames = []
    for frame in source:
        values = frame.values * np.array([shear, shear, 1.0])
        if dead is not None:
            values[divmod(dead, 3)] = 0.0
        frames += [replace(frame, values=values)] if frame.t < 1.5 else []
    first, *_ = (
        event.t for event in events(untared(source.arrays[:1], frames), tare="auto") if event.kind == "tangential_load"
    )
    assert first == pytest.approx(ONSETS[name], abs=0.06)


@pytest.mark.skipif(not REAL.exists(), reason="the papillarray recordings are not available")
def test_a_slow_release_is_no_tangential_load() -> None:
    source = open_source(REAL / "grasp_release_30degree_0offset_23-15-57.npz")
    onsets = [
        event.t
        for event in events(source, tare="auto")
        if event.finger == "sensor-1" and event.kind == "tangential_load"
    ]
    assert not [t for t in onsets if 0.95 < t < 4.479]  # from 0.5 s after the peak to the release


@pytest.mark.skipif(not REAL.exists(), reason="the papillarray recordings are not available")
@pytest.mark.parametrize(("tempo", "gain"), [(2.0, 1.0), (1.0, 4.0), (2.0, 4.0)])
def test_contact_and_release_at_any_tempo_and_gain(tempo: float, gain: float) -> None:
    path = REAL / "grasp_release_0degree_7offset_22-32-44.npz"
    source = open_source(path)
    frames = [replace(frame, t=frame.t / tempo, values=gain * frame.values) for frame in source]
    found = events(untared(source.arrays, frames), tare="auto")
    with (REAL / "labels.csv").open() as file:
        labels = {f"sensor-{row['sensor']}": row for row in csv.DictReader(file) if row["recording"] == path.stem}
    assert len(labels) == 2
    for name, row in labels.items():
        known = float(row["contact_s"]), float(row["release_s"])
        times = [[e.t for e in found if (e.finger, e.kind) == (name, kind)] for kind in ("contact", "release")]
        assert [len(some) for some in times] == [1, 1]
        assert [some[0] for some in times] == pytest.approx([t / tempo for t in known], abs=0.05)
