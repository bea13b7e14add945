"""Emulator, live run and recorder as separate processes: Ctrl-C and kill -9."""

import json
import os
import signal
import time
from pathlib import Path

import numpy as np

from tactile.recording.reader import open_recording
from tactile.wire.packets import packets
from tests.kits.processes import start, wait_until
from tests.kits.serial import GRIP, device, grip, sent, write_array


def test_ctrl_c_closes_the_recording_and_ends_the_emulator(tmp_path: Path) -> None:
    link, array, mcap = tmp_path / "skin", tmp_path / "array.toml", tmp_path / "r.mcap"
    emulator = start(
        "emulate", "--protocol", "lowiek", "--scene", GRIP, "--link", link, "--write-array", array, "--loop"
    )
    reader = None
    try:
        assert emulator.stdout is not None
        assert emulator.stdout.readline() == f"{link}\n"
        reader = start("live", "-p", link, "-a", array, "--record", mcap, "--json", "--tare", "off")
        assert reader.stdout is not None
        first = reader.stdout.readline()
        assert json.loads(first)["type"] in ("event", "status")
        reader.send_signal(signal.SIGINT)
        out, errors = reader.communicate(timeout=30)
        assert (reader.returncode, errors) == (0, "")
        end = json.loads(out.splitlines()[-1])
        assert end["type"] == "end"
        assert end["counts"]["good"] > 10
        emulator.send_signal(signal.SIGTERM)
        _, errors = emulator.communicate(timeout=30)
        assert emulator.returncode == 0
        assert errors.startswith("sent ")
    finally:
        for process in (emulator, reader):
            if process is not None and process.poll() is None:
                process.kill()
                process.communicate()
    assert not os.path.lexists(link)
    recorded = open_recording(mcap)
    assert recorded.complete
    assert recorded.counts is not None
    assert recorded.counts["counts"] == end["counts"]


def test_a_killed_recorder_loses_at_most_half_a_second(tmp_path: Path) -> None:
    description, _ = sent("native", 0.1)
    scene = grip(6.0)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    with device(list(packets(description, scene))) as emulator:
        recorder = start("record", "-p", emulator.port, "-a", array, "-o", mcap)
        wait_until(lambda: mcap.exists() and mcap.stat().st_size >= 100_000)
        recorder.kill()
        killed = time.time_ns()
        recorder.communicate()
    recorded = open_recording(mcap)
    assert not recorded.complete
    frames = [frame.sequence for frame in recorded.source() if frame.finger == 0]
    assert len(frames) > 50
    assert (np.diff(frames) == 1).all()
    last = max(chunk.t for chunk in recorded.chunks())
    assert (killed - recorded.start - last) * 1e-9 < 0.5
