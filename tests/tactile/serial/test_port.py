"""Serial ports on a pseudo-terminal: round trips, unplugging, stalls, errors, listing."""

import errno
import importlib
import itertools
import re
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
import serial

from cnnsim.support import InputError
from tactile.core.frame import Frame
from tactile.serial.faults import Faults
from tactile.serial.port import CURES, open_port
from tactile.serial.reader import PortReader
from tactile.serial.ring import CHUNK_COST, Ring
from tactile.serial.session import Session
from tactile.wire.base import Encoder, Talk
from tactile.wire.description import Description
from tactile.wire.packets import emulated_description, packets
from tactile.wire.registry import NAMES, find_format
from tactile.wire.source import UNPLUGGED, Chunk, WireSource
from tests.kits.serial import call, device, grip, sent

LIMIT = 20.0
"""Time limit of a test [s]."""


def read_all(description: Description, port: str, wanted: int) -> tuple[list[Frame], Session]:
    """Read `wanted` frames from a port."""
    session = Session(port, description, seconds=LIMIT)
    frames = []
    for frame in session.source:
        frames.append(frame)
        if len(frames) == wanted:
            session.stop()
    return frames, session


@pytest.mark.parametrize("protocol", NAMES)
def test_frames_of_every_protocol_arrive_through_a_terminal(protocol: str) -> None:
    description, stream = sent(protocol, 0.2)
    direct = list(WireSource(description, [Chunk(0, data) for _, data in stream]))
    with device(stream, device=description.wire.encoder(description.options)) as emulator:
        frames, session = read_all(description, emulator.port, len(direct))
    assert len(frames) == len(direct) == 40 * len(description.boards)
    for frame, other in zip(frames, direct, strict=True):
        assert (frame.finger, frame.sequence) == (other.finger, other.sequence)
        assert np.array_equal(frame.values, other.values)
    counts = session.counts.plain()
    expected = {"good": counts["good"], "resynchronised": 30 if protocol == "csv" else 0, "late": counts["late"]}
    assert counts == dict.fromkeys(counts, 0) | expected
    assert all(a.t <= b.t for a, b in itertools.pairwise(frames))
    # resolution in strain: 0.1 N of 5 N per 0.01, 0.242 uT of 1000 uT per 0.01, or single precision
    step = {"paxini-fast": 2e-4, "paxini-serial": 2e-4, "lowiek": 2.42e-6}.get(protocol, 1e-8)
    for frame, true in zip(frames, grip(0.2, len(description.boards)), strict=True):
        assert np.abs(frame.values - true.values).max() <= 0.501 * step


def test_a_reader_continues_after_unplugging(tmp_path: Path) -> None:
    description, stream = sent("native", 2.4)
    faults = Faults(unplug=0.3, unplug_for=0.2)
    with device(stream, faults, link=tmp_path / "skin") as emulator:
        session = Session(emulator.port, description, seconds=LIMIT)
        sequences = []
        for frame in session.source:
            sequences.append(frame.sequence)
            if session.reader.unplugged >= 3 and frame.sequence > 400:
                session.stop()
    assert emulator.unplugged >= 3
    assert sequences == sorted(sequences)
    # all frames of both fingers are good or missing, except one cut by unplugging
    span = 2 * (sequences[-1] - sequences[0] + 1)
    assert session.counts.missing + session.counts.good == pytest.approx(span, abs=1)
    assert session.counts.missing > 0
    assert session.counts.bad_checksum == 0


def test_a_second_reader_gets_no_frames_from_before_it_opened_the_port() -> None:
    description, stream = sent("native", 3.0)
    with device(stream) as emulator:
        read_all(description, emulator.port, 40)
        time.sleep(0.3)
        frames, session = read_all(description, emulator.port, 100)
    sequences = [frame.sequence for frame in frames if frame.finger == 0]
    assert sequences[0] > 60
    assert np.diff(sequences).tolist() == [1] * (len(sequences) - 1)
    assert session.counts.missing == 0


def test_frames_after_a_stall_count_as_late() -> None:
    description, stream = sent("native", 1.2)
    with device(stream, Faults(stall=0.6, stall_for=0.15)) as emulator:
        _, session = read_all(description, emulator.port, 480)
    assert session.counts.good == 480
    assert session.counts.late >= 5


def test_a_reader_that_falls_behind_is_reported_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tactile.serial.session.BEHIND", 0.2)
    description, stream = sent("native", 0.7)
    warnings: list[str] = []
    with device(stream) as emulator:
        running = Session(emulator.port, description, seconds=10, once=True, warn=warnings.append)
        for number, _ in enumerate(running.source):
            time.sleep(0.4 if number == 20 else 0)
    (text,) = warnings
    found = re.match(r"frames are processed (0\.\d) s after their arrival: (\d+) frames \((\d+) bytes\) wait", text)
    assert found is not None, text
    assert 40 <= int(found[2]) <= 220  # 2 x 200 frames a second
    assert running.counts.good == 280


def test_ports_that_do_not_open_name_the_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="there is no such port"):
        open_port(str(tmp_path / "none"), 115200)
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="not a serial port"):
        open_port(str(tmp_path / "file"), 115200)
    _, stream = sent("native", 0.1)
    with (
        device(stream) as emulator,
        open_port(emulator.port, 115200),
        pytest.raises(InputError, match="another reader"),
    ):
        open_port(emulator.port, 115200)

    for number, cure in ((errno.EACCES, "dialout"), (errno.EBUSY, "close that first"), (errno.ENOENT, "plugged in")):
        error = serial.SerialException(number, "could not open port")
        monkeypatch.setattr(serial, "Serial", Mock(side_effect=error))
        with pytest.raises(InputError, match=cure):
            open_port("any", 115200)
    assert len(set(CURES.values())) >= 6


def test_the_hello_is_sent_once_and_the_poll_repeatedly() -> None:
    received = bytearray()

    class Listener(Encoder):
        def encode(self, *_: Any) -> bytes:
            return b""

        def receive(self, data: bytes) -> bytes:
            received.extend(data)
            return b""

    def stream() -> Iterator[tuple[float, bytes]]:
        for n in range(60):
            yield n * 0.01, b"x"

    with device(stream(), device=Listener()) as emulator:
        came: list[Chunk] = []
        reader = PortReader(emulator.port, 115200, Talk(b"hello", b"?", 0.05), came.extend)
        reader.start()
        until = time.monotonic() + LIMIT
        while received.count(b"?") < 3 and time.monotonic() < until:
            time.sleep(0.01)
        reader.close()
    assert received.startswith(b"hello?")
    assert received.count(b"hello") == 1
    assert b"".join(chunk.data for chunk in came).startswith(b"x")


def test_a_full_ring_counts_the_overflow_and_does_not_block() -> None:
    ring = Ring(10 * (100 + CHUNK_COST))
    took = [ring.put(Chunk(n, bytes(100))) for n in range(25)]
    assert took == [True] * 10 + [False] * 15
    assert ring.overflowed == 1500
    assert ring.put(Chunk(99, note=UNPLUGGED))  # notes are never dropped
    assert [chunk.t for chunk in ring.get(0)] == [*range(10), 99]
    assert ring.get(0) == []
    assert ring.put(Chunk(0, bytes(100)))


def test_a_looped_scene_continues_its_sequence_numbers() -> None:
    scene = grip(0.1)
    description = emulated_description("native", scene)
    looped = list(itertools.islice(packets(description, scene, loop=True), 50))
    times = np.array([t for t, _ in looped])
    assert np.diff(times) == pytest.approx(np.full(49, 0.005), abs=1e-9)
    frames = list(WireSource(description, [Chunk(0, data) for _, data in looped]))
    assert [frame.sequence for frame in frames[::2]] == list(range(50))


def test_ports_are_listed_with_likely_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    import serial.tools.list_ports as listing

    found = [
        SimpleNamespace(device="/dev/ttyS0", description="n/a", vid=None, pid=None),
        SimpleNamespace(device="/dev/ttyACM0", description="board", vid=0x16C0, pid=0x0483),
    ]
    monkeypatch.setattr(listing, "comports", lambda: found)
    result = call("ports")
    assert result.output.splitlines() == ["/dev/ttyACM0  board 16c0:0483  (Teensy)", "/dev/ttyS0  n/a"]
    monkeypatch.setattr(listing, "comports", list)
    assert "no serial ports" in call("ports").output


def test_a_missing_library_names_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise ModuleNotFoundError(f"No module named {name!r}", name="cobs")

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(InputError, match=r"needs cobs.*pip install .*\[serial\]"):
        find_format("native")
