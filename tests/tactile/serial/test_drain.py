"""The process that drains a port: no lost bytes while the reader is stopped, true times, restart after a kill."""

import os
import signal
import subprocess
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.recording.reader import open_recording
from tactile.recording.writer import Recording
from tactile.serial import reader as reader_module
from tactile.serial.drain import CAPACITY
from tactile.serial.drained import Drained
from tactile.serial.emulator import Emulator
from tactile.serial.session import Session
from tactile.wire.packets import emulated_description, packets
from tests.kits.processes import code_line, start, wait_until
from tests.kits.serial import GRIP, call, device, grip, sent, write_array

LIMIT = 20.0


class Stamped(Emulator):
    """A device that records the time of each packet sent [ns since 1970]."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self.times: list[int] = []

    def _send(self, packet: bytes) -> None:
        self.times.append(time.time_ns())
        super()._send(packet)


def test_frames_are_logged_with_their_time_of_arrival(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Never before they were sent; in one of six tries, on a busy machine, within 5 ms."""
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


@pytest.mark.filterwarnings("ignore:the device's clock")
def test_no_frame_is_lost_while_the_reader_is_stopped(tmp_path: Path) -> None:
    """The recorder is stopped for 0.8 s, in which several times the 64 KiB arrive that a terminal buffers."""
    scene = grip(4.0)
    description = emulated_description("native", scene)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    fast = ((t / 10, data) for t, data in packets(description, scene, loop=True))  # 2000 frames a second
    with device(fast) as emulator:
        recorder = start("record", "-p", emulator.port, "-a", array, "-o", mcap)
        wait_until(lambda: mcap.exists() and mcap.stat().st_size >= 50_000)
        os.kill(recorder.pid, signal.SIGSTOP)
        time.sleep(0.8)
        os.kill(recorder.pid, signal.SIGCONT)
        time.sleep(0.2)
        recorder.send_signal(signal.SIGHUP)  # the terminal is closed
        out, errors = recorder.communicate(timeout=30)
    assert (recorder.returncode, errors.count("\n")) == (0, 1), errors
    assert "the device's clock advances" in errors  # the stream is ten times as fast as its stamps
    assert ", 0 missing" in out
    again = open_recording(mcap)
    assert again.complete
    sequences = [frame.sequence for frame in again.source() if frame.finger == 0]
    assert np.diff(sequences).tolist() == [1] * (len(sequences) - 1)
    times = np.array([chunk.t for chunk in again.chunks() if chunk.data]) * 1e-9
    assert np.diff(times).max() < 0.4  # the drain kept recording times


def test_the_drain_ends_with_its_reader() -> None:
    drain = Drained()
    process = drain._process
    assert process.poll() is None
    drain._link.close()
    assert process.wait(timeout=LIMIT) == 0
    assert CAPACITY > 60 * 1000 * 800  # a minute of 64 taxels


def test_a_killed_drain_is_restarted() -> None:
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


def test_a_thread_reads_where_a_port_cannot_be_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader_module, "CAN_DRAIN", False)
    description, stream = sent("native", 0.3)
    with device(stream) as emulator:
        session = Session(emulator.port, description, once=True, seconds=LIMIT)
        assert sum(1 for _ in session.source) == 120
    assert session.counts.missing == 0


def test_a_port_is_reopened_within_a_second(tmp_path: Path) -> None:
    """After two seconds without the port."""
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
def test_ctrl_c_during_start_prints_no_traceback(tmp_path: Path, delay: float) -> None:
    description, _ = sent("native", 0.1)
    array = write_array(tmp_path, description.text)
    code = code_line("from tactile.cli.start import main; print(flush=True); main()")
    command = [*code, "live", "-p", str(tmp_path / "none"), "-a", str(array)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as reader:
        assert reader.stdout is not None
        reader.stdout.readline()  # the interpreter has started
        time.sleep(delay)
        reader.send_signal(signal.SIGINT)
        _, errors = reader.communicate(timeout=30)
    assert reader.returncode != 0
    assert "Traceback" not in errors


def test_sighup_ends_an_emulator_and_removes_its_link(tmp_path: Path) -> None:
    link = tmp_path / "skin"
    emulator = start("emulate", "--protocol", "native", "--scene", GRIP, "--link", link)
    wait_until(link.is_symlink)
    emulator.send_signal(signal.SIGHUP)
    assert "sent 0 packets" in emulator.communicate(timeout=20)[1]
    assert not os.path.lexists(link)
    assert call("ports").exit_code == 0
