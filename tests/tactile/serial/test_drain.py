"""The process that drains a port: nothing is lost while the reader is away, and every byte has its true time."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.recording.reader import open_recording
from tactile.recording.writer import Recording
from tactile.serial import reader as reader_module
from tactile.serial.drain import CAPACITY, DATA, GONE
from tactile.serial.drained import Drained
from tactile.serial.emulator import Emulator
from tactile.serial.port import open_port
from tactile.serial.reader import PortReader
from tactile.serial.session import Session
from tactile.wire.base import Talk
from tactile.wire.packets import emulated_description, packets
from tactile.wire.source import Chunk
from tests.kits.processes import start
from tests.kits.serial import GRIP, call, device, grip, sent, write_array

LIMIT = 20.0


class Stamped(Emulator):
    """A device that notes when it sent each packet [ns since 1970]."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self.times: list[int] = []

    def _send(self, packet: bytes) -> None:
        self.times.append(time.time_ns())
        super()._send(packet)


def test_frames_are_logged_when_they_came(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Never before they were sent; and in one of a few tries, since others use the machine too, within 5 ms."""
    monkeypatch.setattr("tests.kits.serial.Emulator", Stamped)
    description, stream = sent("native", 0.6)
    latest: list[float] = []
    for n in range(6):
        path = tmp_path / f"{n}.mcap"
        with device(stream) as emulator:
            session = Session(emulator.port, description, partial(Recording, path, description, {}), once=True)
            for _ in session.source:
                pass
            session.close()
            assert session.recording is not None
            session.recording.close({})
        assert isinstance(emulator, Stamped)
        again = open_recording(path)
        logged = [again.start + chunk.t for chunk in again.chunks() for _ in range(chunk.data.count(b"\0") // 2)]
        behind = np.array(logged[-100:]) - emulator.times[-100:]
        assert len(emulator.times) == 120
        assert behind.min() >= 0
        latest.append(behind.max() * 1e-6)
        if latest[-1] < 5.0:
            return
    pytest.fail(f"frames were logged up to {latest} ms after they were sent")


def test_nothing_is_lost_while_the_reader_cannot_run(tmp_path: Path) -> None:
    """A recorder that is stopped for most of a second, as a busy machine may do, has all the same every frame.

    A terminal holds 64 KiB at most; what comes meanwhile is several times as much."""
    scene = grip(4.0)
    description = emulated_description("native", scene)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    fast = ((t / 10, data) for t, data in packets(description, scene, loop=True))  # 2000 frames a second
    with device(fast) as emulator:
        recorder = start("record", "-p", emulator.port, "-a", array, "-o", mcap)
        until = time.monotonic() + LIMIT
        while not mcap.exists() or mcap.stat().st_size < 50_000:
            assert time.monotonic() < until
            time.sleep(0.01)
        os.kill(recorder.pid, signal.SIGSTOP)
        time.sleep(0.8)
        os.kill(recorder.pid, signal.SIGCONT)
        time.sleep(0.2)
        recorder.send_signal(signal.SIGHUP)  # the end of the terminal
        out, errors = recorder.communicate(timeout=30)
    assert (recorder.returncode, errors) == (0, "")
    assert ", 0 missing" in out
    again = open_recording(mcap)
    assert again.complete
    sequences = [frame.sequence for frame in again.source() if frame.finger == 0]
    assert np.diff(sequences).tolist() == [1] * (len(sequences) - 1)
    times = np.array([chunk.t for chunk in again.chunks() if chunk.data]) * 1e-9
    assert np.diff(times).max() < 0.4  # the drain went on stamping


def drained(stream: list[tuple[float, bytes]], talk: Talk = Talk()) -> Iterator[tuple[int, int, bytes]]:  # noqa: B008
    drain = Drained()
    with device(stream) as emulator, open_port(emulator.port, 115200) as port:
        drain.read(port, talk)
        until = time.monotonic() + LIMIT
        while time.monotonic() < until:
            for record in drain.take(0.1):
                yield record
                if record[0] == GONE:
                    drain.close()
                    return
    pytest.fail("the port was never gone")


def test_a_port_that_is_gone_is_told_after_all_that_came() -> None:
    stream = [(0.002 * n, b"%04d" % n) for n in range(100)]
    records = list(drained(stream))
    assert b"".join(data for kind, _, data in records if kind == DATA) == b"".join(data for _, data in stream)
    times = [t for _, t, _ in records]
    assert times == sorted(times)
    assert records[-1][0] == GONE


def test_the_drain_ends_with_its_reader() -> None:
    drain = Drained()
    process = drain._process
    assert process.poll() is None
    drain._link.close()
    assert process.wait(timeout=LIMIT) == 0
    assert CAPACITY > 60 * 1000 * 800  # a minute of 64 taxels


def test_a_drain_that_is_killed_is_started_again() -> None:
    description, stream = sent("native", 3.0)
    with device(stream) as emulator:
        session = Session(emulator.port, description, seconds=LIMIT)
        frames = 0
        for _ in session.source:
            frames += 1
            if frames == 40:
                assert session.reader._drained is not None
                session.reader._drained._process.kill()
            if frames > 200 and session.reader.unplugged:
                session.stop()
    assert session.reader.unplugged == 1
    assert frames > 200


def test_where_no_port_can_be_handed_over_a_thread_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader_module, "CAN_DRAIN", False)
    description, stream = sent("native", 0.3)
    with device(stream) as emulator:
        session = Session(emulator.port, description, once=True, seconds=LIMIT)
        assert sum(1 for _ in session.source) == 120
    assert session.counts.missing == 0


def test_a_port_is_found_soon_after_it_is_back(tmp_path: Path) -> None:
    """Away for two seconds; with pauses that double without end it took 3.6 s more."""
    link = tmp_path / "skin"
    description, stream = sent("native", 0.2)
    with device(stream, link=link):
        session = Session(str(link), description, seconds=LIMIT)
        frames = iter(session.source)
        next(frames)
        for _ in frames:
            if session.source.decoder.counts.good == 80:
                break
    time.sleep(2.0)
    back = time.monotonic()
    with device(packets(description, grip(1.0), loop=True), link=link):
        while session.reader.why or not session.reader.unplugged:
            assert time.monotonic() < back + LIMIT
            time.sleep(0.01)
        assert time.monotonic() - back < 1.0
        session.close()
    for _ in frames:
        pass


@pytest.mark.parametrize("delay", [0.15, 0.5])
def test_ctrl_c_while_it_starts_leaves_no_traceback(tmp_path: Path, delay: float) -> None:
    description, _ = sent("native", 0.1)
    array = write_array(tmp_path, description.text)
    reader = start("live", "-p", tmp_path / "none", "-a", array)
    time.sleep(delay)
    reader.send_signal(signal.SIGINT)
    _, errors = reader.communicate(timeout=30)
    assert reader.returncode != 0
    assert "Traceback" not in errors


def test_the_end_of_the_terminal_ends_an_emulator_in_good_order(tmp_path: Path) -> None:
    link = tmp_path / "skin"
    emulator = start("emulate", "--protocol", "native", "--scene", GRIP, "--link", link)
    until = time.monotonic() + LIMIT
    while not link.is_symlink():
        assert time.monotonic() < until
        time.sleep(0.01)
    emulator.send_signal(signal.SIGHUP)
    assert "sent 0 packets" in emulator.communicate(timeout=20)[1]
    assert not os.path.lexists(link)
    assert call("ports").exit_code == 0


def test_who_waits_takes_what_comes_himself_and_the_thread_what_he_leaves() -> None:
    """One packet a time goes through no other thread; of somebody who is busy everything is handed on all the same."""
    stream = [(0.01 * n, b"%04d" % n) for n in range(60)]
    came: list[tuple[int, bytes]] = []

    def keep(chunks: list[Chunk]) -> None:
        came.extend((threading.get_ident(), chunk.data) for chunk in chunks if chunk.data)

    with device(stream) as emulator:
        reader = PortReader(emulator.port, 115200, Talk(), keep, once=True)
        reader.start()
        until = time.monotonic() + LIMIT
        while len(came) < 20 and time.monotonic() < until:
            reader.poll(0.1)
        polled = [who == threading.get_ident() for who, _ in came]
        while not came[-1][1].endswith(stream[-1][1]) and time.monotonic() < until:
            time.sleep(0.05)
        reader.close()
    assert sum(polled) > len(polled) / 2
    assert not any(who == threading.get_ident() for who, _ in came[len(polled) :])
    assert b"".join(data for _, data in came) == b"".join(data for _, data in stream)


def test_reading_begins_when_somebody_takes_what_comes() -> None:
    """What came while he was still busy would wait for him, and be late."""
    description = emulated_description("native", grip(4.0))
    with device(packets(description, grip(4.0), loop=True)) as emulator:
        session = Session(emulator.port, description, seconds=LIMIT)
        time.sleep(0.3)
        begun = session.now()
        next(iter(session.source))
        assert session.source.arrival >= begun
        session.close()
