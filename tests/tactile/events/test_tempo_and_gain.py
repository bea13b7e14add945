"""Grips of real recordings that are played faster and with other gains: the same contact, the same release."""

import csv
from dataclasses import replace

import pytest

from tactile.core.source import FrameStream, Provenance
from tactile.events.event import EventLog
from tactile.pipeline import run
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.paths import DATA

PATH = DATA / "papillarray" / "grasp_release_0degree_7offset_22-32-44.npz"


@pytest.mark.skipif(not PATH.exists(), reason="the recordings lie beside the project, and are not here")
@pytest.mark.parametrize(("tempo", "gain"), [(2.0, 1.0), (1.0, 4.0), (2.0, 4.0)])
def test_a_grip_is_told_at_any_tempo_and_gain(tempo: float, gain: float) -> None:
    source = open_source(PATH)
    frames = [replace(frame, t=frame.t / tempo, values=gain * frame.values) for frame in source]
    stream, log = FrameStream("", source.arrays, None, len(frames), frames, Provenance(untared=True)), EventLog()
    run(stream, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    with (PATH.parent / "labels.csv").open() as file:
        labels = {f"sensor-{row['sensor']}": row for row in csv.DictReader(file) if row["recording"] == PATH.stem}
    assert len(labels) == 2
    for name, row in labels.items():
        known = float(row["contact_s"]), float(row["release_s"])
        of = [[e.t for e in log.events if (e.finger, e.kind) == (name, kind)] for kind in ("contact", "release")]
        assert [len(found) for found in of] == [1, 1]
        assert [found[0] for found in of] == pytest.approx([t / tempo for t in known], abs=0.05)
