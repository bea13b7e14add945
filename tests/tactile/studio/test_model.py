"""The model of the live array view: what a page gets is what the pipeline gives, without a browser."""

import json
from typing import Any

import numpy as np
import pytest

from cnnsim.studio.message import Message, pack
from cnnsim.support import InputError
from tactile import Settings, Threshold, open_source
from tactile.events.code import hand_code
from tactile.pipeline import run
from tactile.studio import feed as feeds
from tactile.studio.feed import Feed
from tactile.studio.model import SPAN, ArrayModel
from tests.kits.serial import GRIP
from tests.tactile.studio.conftest import Known, finished

T = 3.05
"""Both fingers slip."""


def ask(model: ArrayModel, do: str, **content: Any) -> Message:
    reply = model.receive(Message({"do": do, **content}))
    pack(reply)
    return reply


def named(events: list[Any]) -> list[tuple[str, str, float]]:
    """Return what identifies events, of the model or of the pipeline."""
    plain = [one if isinstance(one, dict) else vars(one) for one in events]
    return sorted((one["finger"], one["kind"], round(one["t"], 6)) for one in plain)


def test_a_frame_is_the_report_of_the_pipeline(known: Known) -> None:
    reply = ask(ArrayModel(known.feed), "frame", t=T)
    reports = known.at(T)
    for report, finger, data in zip(reports, reply.content["fingers"], reply.buffers[::2], strict=True):
        values = np.frombuffer(data, np.float32).reshape(2, 2, 3)
        assert np.array_equal(values, report.frame.values.astype(np.float32))
        assert finger["t"] == report.frame.t
        assert finger["load"]["F"] == report.load.F
        assert (finger["load"]["x"], finger["load"]["y"]) == (report.load.x, report.load.y)
        assert finger["arrows"] == report.code.arrows()
        assert finger["friction"] == report.texture.friction.item()
    bits = "".join(finger["bits"] for finger in reply.content["fingers"])
    assert int(bits, 2) == hand_code([report.code for report in reports])


def test_one_scale_is_the_largest_of_all_fingers(known: Known) -> None:
    scale = ask(ArrayModel(known.feed), "frame", t=T).content["scales"]["strain"]
    values = np.array([report.frame.values for report in known.reports])
    assert scale["normal"] == np.abs(values[..., 2]).max()
    assert scale["shear"] == np.hypot(values[..., 0], values[..., 1]).max()
    assert scale["key"] == pytest.approx(0.02)


def test_events_have_their_spans_and_come_only_when_they_change(known: Known) -> None:
    model = ArrayModel(known.feed)
    events = ask(model, "frame", t=99.0).content["events"]
    assert "events" not in ask(model, "frame", t=99.0).content
    begun = [event for report in known.reports for event in report.events]
    assert named(events) == named(begun)
    ends = {event.key: event.end for report in known.reports for event in report.ended}
    assert {(one["finger"], one["kind"], one["t"]): one["end"] for one in events if one["end"]} == ends
    assert not [one for one in ask(model, "frame", t=1.0).content["events"] if one["t"] > 1.0]


def test_a_contact_is_on_as_many_taxels_as_it_pressed(known: Known) -> None:
    ask(model := ArrayModel(known.feed), "frame", t=T)
    (words,) = {one.words for one in known.feed.events.values() if one.kind == "contact" and one.t < T}
    assert max(int(one.code.contact.sum()) for one in known.reports if one.frame.t <= T) == 4
    assert words == "contact on 4 of 4 taxels"
    assert "contact on 4 of 4" in str(ask(model, "thresholds", t=T).content["events"])


def test_the_planes_of_a_program_come_with_the_frame(known: Known) -> None:
    reply = ask(ArrayModel(known.feed), "frame", t=T)
    for report, finger, data in zip(known.at(T), reply.content["fingers"], reply.buffers[1::2], strict=True):
        plane, count = finger["outputs"]
        assert (plane["program"], plane["name"], plane["shape"]) == ("touched", "pressed", (2, 2))
        black = np.frombuffer(data, np.uint8).reshape(2, 2) == 240
        assert np.array_equal(black, report.code.contact)
        assert count["value"] == [report.code.contact.sum()]


def test_curves_are_the_figures_over_time(known: Known) -> None:
    reply = ask(ArrayModel(known.feed), "series", t=T)
    t, force, friction, roughness = np.frombuffer(reply.buffers[1], np.float32).reshape(4, -1)
    reports = {np.float32(one.frame.t): one for one in known.reports if one.frame.finger == 1}
    assert 150 < t.size <= 301
    assert T - SPAN <= t[0] < t[-1] <= T
    assert np.array_equal(force, np.array([reports[at].load.F for at in t], np.float32), equal_nan=True)
    for found, name in ((friction, "friction"), (roughness, "roughness")):
        wanted = np.array([getattr(reports[at].texture, name).item() for at in t], np.float32)
        assert np.array_equal(found, wanted, equal_nan=True)


@pytest.mark.parametrize("t", [T, 5.5])
def test_the_same_thresholds_make_the_same_events_again(t: float, known: Known) -> None:
    found = ask(ArrayModel(known.feed), "thresholds", t=t).content
    assert named(found["events"]) == named([one for one in known.feed.events_between(t - 5, t) if one.told <= t])
    assert found["count"] == found["now"] > 10


def test_other_thresholds_make_the_events_of_a_run_with_them(known: Known) -> None:
    found = ask(ArrayModel(known.feed), "thresholds", t=99.0, dead_band=0.02, contact_level=0.02).content
    events: list[Any] = []
    run(
        open_source(GRIP),
        Settings(Threshold(0.02, 0.01), Threshold(0.02, 0.01)),
        [lambda report: events.extend(report.events)],
    )
    wanted = [event for event in events if event.t >= found["begin"]]
    assert named([one for one in found["events"] if one["t"] >= found["begin"]]) == named(wanted)
    assert found["count"] == len(wanted) < found["now"]
    assert found["options"] == "--dead-band 0.02 --contact-level 0.02"
    nothing = ask(ArrayModel(known.feed), "thresholds", t=99.0, contact_level=10.0, sigmas=[4, 6, 3]).content
    assert nothing["count"] == 0
    assert nothing["options"] == "--contact-level 10 --sigmas 4 6 3"


@pytest.mark.parametrize(
    "content",
    [{"do": "nothing"}, {"do": "frame", "t": "now"}, {"do": "frame", "t": json.loads("NaN")}, {"do": "tare"},
     {"do": "record", "on": True}, {"do": "thresholds", "dead_band": "x"}, {"do": "thresholds", "dead_band": -1},
     {"do": "thresholds", "hysteresis": 1}, {"do": "thresholds", "sigmas": [1, 2]}, {"do": "thresholds", "sigmas": 3}],
    ids=str,
)  # fmt: skip
def test_a_wrong_message_is_refused(content: dict[str, Any], known: Known) -> None:
    with pytest.raises(InputError, match=r"wanted|known are"):
        ArrayModel(known.feed).receive(Message(content))


def test_loops_are_compiled_before_the_first_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    feed, seen = Feed(open_source(GRIP), Settings(), compiling=True), list[Any]()
    model = ArrayModel(feed)
    monkeypatch.setattr("tactile.pipeline.warm_up", lambda *_: seen.append(ask(model, "frame").content))
    feed.start()
    feed.wait()
    assert [(one["compiling"], one["fingers"]) for one in seen] == [(True, [])]
    assert feed.times is not None
    assert not ask(model, "frame").content["compiling"]


def test_a_source_without_frames_has_no_time(known: Known) -> None:
    model = ArrayModel(Feed(open_source(GRIP), Settings()))
    assert ask(model, "frame").content["fingers"] == []
    assert not ask(model, "series").buffers
    with pytest.raises(InputError, match="no frame has come"):
        ask(model, "thresholds")


def test_an_error_of_the_source_is_shown(known: Known) -> None:
    class Broken:
        title, arrays, modulus, frames = "x", known.feed.arrays, 1e6, None

        def __iter__(self) -> Any:
            raise InputError("the file is damaged")

    feed = Feed(Broken(), Settings())
    feed.start()
    feed.wait()
    assert ask(ArrayModel(feed), "frame").content["failure"] == "the file is damaged"


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feeds, "MOST_BYTES", 0)
    full = finished(Settings())
    assert full.full
    assert len(full.rows[0]) == 1001 < 1200
    monkeypatch.setattr(feeds, "LIVE_SECONDS", 1.0)
    live = Feed(open_source(GRIP), Settings(), live=True)
    live.start()
    live.wait()
    assert live.times is not None
    assert live.times[0] > 3
    assert all(row.t >= live.times[0] for row in live.rows[0])
    assert len(live.marks) == 3  # one before, and two after the release
    assert not [event for event in live.events.values() if event.end is not None and event.end < live.times[0]]
    assert len(live.again(Settings(), 5.0, 5.9)) > 0
