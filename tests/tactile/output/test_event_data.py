"""Events of large arrays in events.json: only the changed taxels, from which the whole code follows."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.events.event import Event
from tactile.output.event_data import EventData
from tactile.output.record import RunRecord
from tactile.pipeline import run
from tactile.settings import Settings


def pressed(side: int, frames: int) -> FrameStream:
    """A patch that moves over a force array, with shear to the right."""
    array = TaxelArray("pad", side, side, 1e-3, 0.0, quantity="force")
    stream = []
    for n in range(frames):
        values = np.zeros((side, side, 3))
        values[n : n + 4, n : n + 4] = [1.0, 0.0, 1.0]
        stream.append(Frame(0, n / 100, n, values, np.ones((side, side), bool)))
    return FrameStream("patch", (array,), None, frames, stream)


def recorded(folder: Path, source: FrameStream) -> list[Event]:
    events: list[Event] = []
    with RunRecord(folder, source.arrays, {}) as record:
        run(source, Settings(backend="reference"), [record, lambda report: events.extend(report.events)])
    return events


@pytest.mark.parametrize(("side", "inline"), [(8, True), (9, False)])
def test_codes_follow_from_the_changes(tmp_path: Path, side: int, inline: bool) -> None:
    events = recorded(tmp_path, pressed(side, 5))
    written = json.loads((tmp_path / "events.json").read_text(encoding="utf-8"))["events"]
    assert len(written) == len(events) > 1
    code = ["00"] * side**2
    for one, event in zip(written, events, strict=True):
        assert ("ternary" in one, "arrows" in one, "hand" in one) == (inline, inline, inline)
        if inline:
            assert one["ternary"] == event.ternary
            continue
        change = one["changed"]
        for number, taxel in enumerate(change["taxels"]):
            code[taxel] = change["ternary"][2 * number : 2 * number + 2]
        assert "".join(code) == event.ternary


def test_a_large_array_makes_a_small_file(tmp_path: Path) -> None:
    recorded(tmp_path, pressed(128, 20))
    assert (tmp_path / "events.json").stat().st_size < 20_000  # whole codes take 80 kB per event


def test_changes_are_per_finger(tmp_path: Path) -> None:
    (event, *_) = recorded(tmp_path, pressed(9, 2))
    big, small = pressed(9, 1).arrays[0], TaxelArray("tip", 2, 2, 1e-3, 0.0, quantity="force")
    data = EventData((big, small))
    assert len(data(event)["changed"]["taxels"]) == 16
    assert data(event)["changed"]["taxels"] == []
    assert data(replace(event, finger="tip", ternary="00" * 4))["ternary"] == "00000000"
