"""Recordings: round trip, other MCAP readers, truncated files, ring overflow."""

import random
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.core.frame import Frame
from tactile.recording import schema
from tactile.recording.reader import open_recording
from tactile.recording.records import records
from tactile.recording.writer import Recording
from tactile.serial.ring import Ring
from tactile.serial.session import Session
from tactile.wire.description import Description
from tactile.wire.source import UNPLUGGED, Chunk, WireSource
from tests.kits.serial import device, sent

TARED = {"type": "tare", "t_s": 0.25, "finger": "left", "taken": True, "why": "idle", "offset": [1.0, None, 2.0]}


def recorded(path: Path, protocol: str = "native", seconds: float = 0.5, close: bool = True) -> Description:
    """Record a device's packets, an unplug note, a tare and the frames."""
    description, stream = sent(protocol, seconds)
    recording = Recording(path, description, {"port": "here"}, Epoch.now())

    def chunks() -> Iterator[Chunk]:
        for n, (t, data) in enumerate(stream):
            chunk = Chunk(round(t * 1e9) + 7, data, "")
            recording.chunk(chunk)
            yield chunk
            if n == len(stream) // 2:
                recording.chunk(Chunk(chunk.t + 1, note=UNPLUGGED))
                yield Chunk(chunk.t + 1, note=UNPLUGGED)

    source = WireSource(description, chunks(), see=lambda frame: recording.frame(frame, source.arrival))
    for _ in source:
        recording.push(now=True)
    recording.note("/tare", 250_000_000, TARED)
    if close:
        recording.close({"counts": source.counts.plain()})
    return description


def into(path: Path, description: Description) -> Callable[[Epoch], Recording]:
    return partial(Recording, path, description, {})


def same(got: list[Frame], wanted: list[Frame]) -> None:
    assert len(got) == len(wanted)
    for a, b in zip(got, wanted, strict=True):
        assert (a.finger, a.t, a.sequence) == (b.finger, b.t, b.sequence)
        assert a.t_device == b.t_device or np.isnan([a.t_device, b.t_device]).all()
        assert np.array_equal(a.values, b.values)
        assert np.array_equal(a.valid, b.valid)


@pytest.mark.parametrize("protocol", ["native", "reskin"])
def test_a_recording_round_trips(tmp_path: Path, protocol: str) -> None:
    description = recorded(tmp_path / "r.mcap", protocol)
    again = open_recording(tmp_path / "r.mcap")
    stream = sent(protocol)[1]
    data = [chunk for chunk in again.chunks() if not chunk.note]
    assert [chunk.data for chunk in data] == [packet for _, packet in stream]
    assert [chunk.t for chunk in data] == [round(t * 1e9) + 7 for t, _ in stream]
    assert [chunk.note for chunk in again.chunks() if chunk.note] == [UNPLUGGED]
    frames = list(again.source())
    same(list(again.stored_frames()), frames)
    assert len(frames) == 200
    assert again.complete
    assert again.counts is not None
    assert again.counts["counts"]["good"] == (200 if protocol == "native" else 100)
    assert again.description.text == description.text
    assert again.made["protocol"] == protocol
    assert again.made["port"] == "here"
    (note,) = again.notes("/tare")
    assert note == TARED
    log = [(line["level"], line["name"], line["message"]) for line in again.notes("/log")]
    assert log == [(3, "port", "unplugged"), (2, "left", "tare taken, idle")]


def test_the_mcap_library_and_ros_types_read_it(tmp_path: Path) -> None:
    """The MCAP library's indexed reader and ROS 2 message definitions give the same frames and bytes."""
    recorded(tmp_path / "r.mcap")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.FRAME, schema.FRAME_NAME))
    store.register(get_types_from_msg(schema.WIRE, schema.WIRE_NAME))
    with (tmp_path / "r.mcap").open("rb") as file:
        messages = list(make_reader(file).iter_messages(topics=["/frames/left", "/wire"]))
    wanted = [frame for frame in open_recording(tmp_path / "r.mcap").stored_frames() if frame.finger == 0]
    frames: list[Any] = [
        store.deserialize_cdr(message.data, schema.FRAME_NAME) for _, channel, message in messages
        if channel.topic == "/frames/left"
    ]  # fmt: skip
    assert len(frames) == len(wanted) == 100
    for got, frame in zip(frames, wanted, strict=True):
        assert (got.t, got.sequence, got.finger, got.rows, got.cols) == (frame.t, frame.sequence, 0, 2, 2)
        assert np.array_equal(got.values.reshape(2, 2, 3), frame.values)
        assert got.valid.tolist() == [1, 1, 1, 1]
    wire_data = [message.data for _, channel, message in messages if channel.topic == "/wire"]
    wire: list[Any] = [store.deserialize_cdr(data, schema.WIRE_NAME) for data in wire_data]
    assert b"".join(bytes(one.data) for one in wire) == b"".join(data for _, data in sent("native")[1])


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (1, 5), (3, 3)])
def test_frames_of_every_alignment_round_trip(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    frame = Frame(3, 1.5, -7, rng.standard_normal((*shape, 3)), rng.random(shape) < 0.5, float("nan"))
    same([schema.unpack_frame(schema.pack_frame(frame))], [frame])


def test_a_truncated_recording_is_read_up_to_the_cut(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap", seconds=0.1, close=False)
    whole = (tmp_path / "r.mcap").read_bytes()
    frames = list(open_recording(tmp_path / "r.mcap").stored_frames())
    assert len(frames) == 40
    rng, lengths, begin = random.Random(4), [], whole.index(b"left")
    for cut in sorted(rng.sample(range(begin + 3000, len(whole)), 60)):
        (tmp_path / "cut.mcap").write_bytes(whole[:cut])
        again = open_recording(tmp_path / "cut.mcap")
        assert not again.complete
        assert again.counts is None
        got = list(again.stored_frames())
        same(got, frames[: len(got)])
        lengths.append(len(got))
    assert lengths == sorted(lengths)
    assert len(set(lengths)) > 20
    for bad in (whole[:5], b"text that is no recording", whole[:9]):
        (tmp_path / "bad.mcap").write_bytes(bad)
        with pytest.raises(InputError, match="not a recording"):
            open_recording(tmp_path / "bad.mcap")
    with pytest.raises(InputError, match="cannot be read"):
        list(records(tmp_path / "none.mcap"))


def test_bytes_that_overflow_the_ring_are_still_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    description, stream = sent("native", 0.5)
    monkeypatch.setattr("tactile.serial.session.Ring", lambda: Ring(3000))
    with device(stream) as emulator:
        session = Session(emulator.port, description, into(tmp_path / "r.mcap", description))
        frames = iter(session.source)
        live = [next(frames)]
        until = time.monotonic() + 20
        while session.counts.overflowed == 0 and time.monotonic() < until:
            time.sleep(0.01)  # frames are not consumed, so the ring fills
        session.stop()
        live += frames
        assert session.recording is not None
        session.recording.close({})
    again = open_recording(tmp_path / "r.mcap")
    assert session.counts.overflowed > 0
    assert again.messages["/wire/unparsed"] >= 1
    same(list(again.source()), live)
