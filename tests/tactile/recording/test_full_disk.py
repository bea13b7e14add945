"""Recording until the file system or the file size limit is full: a message, and a readable file."""

import os
import resource
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tactile.recording.reader import open_recording
from tactile.wire.packets import packets
from tests.kits.processes import start
from tests.kits.serial import call, device, grip, sent

ROOM = 160 * 1024


@contextmanager
def small_disk(path: Path) -> Iterator[Path]:
    """Mount a file system of `ROOM` bytes in memory, or skip the test."""
    path.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", str(path)]
    try:
        done = subprocess.run(mount, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("no mount command")
    if done.returncode:
        pytest.skip(f"cannot mount a file system: {done.stderr.strip()}")
    try:
        yield path
    finally:
        subprocess.run(["umount", "-l", str(path)], check=False)


def check_readable(path: Path, least: int) -> None:
    again = open_recording(path)
    assert not again.complete
    frames, stored = list(again.source()), list(again.stored_frames())
    for finger in range(2):
        sequences = [frame.sequence for frame in frames if frame.finger == finger]
        assert sequences == list(range(len(sequences)))
        assert len(sequences) > least
    assert [frame.sequence for frame in stored] == [frame.sequence for frame in frames[: len(stored)]]
    assert len(frames) - len(stored) < 100


@pytest.mark.parametrize("command", ["record", "live"])
def test_a_full_file_system_ends_the_recording_with_a_message(tmp_path: Path, command: str) -> None:
    description, _ = sent("native", 0.1)
    array = tmp_path / "array.toml"
    array.write_text(description.text, encoding="utf-8")
    with small_disk(tmp_path / "disk") as disk, device(packets(description, grip(4.0), loop=True)) as emulator:
        mcap = disk / "r.mcap"
        options = ["-o", mcap] if command == "record" else ["--record", mcap, "--tare", "off"]
        result = call(command, "-p", emulator.port, "-a", array, "--seconds", "20", *options)
        assert result.exit_code == 2, result.output
        assert f"recording {mcap} ended: No space left on device; what was written until then can be read" in (
            result.stderr
        )
        assert "good, 0 bad checksum" in result.stdout
        assert ROOM / 2 < mcap.stat().st_size <= ROOM
        assert os.statvfs(disk).f_bavail <= 12  # pages of 4 KiB
        check_readable(mcap, 50)


def test_a_file_size_limit_ends_the_recording_with_a_message(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """SIGXFSZ does not kill the recorder."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # cached modules would be truncated
    description, _ = sent("native", 0.1)
    array, mcap = tmp_path / "array.toml", tmp_path / "r.mcap"
    array.write_text(description.text, encoding="utf-8")
    with device(packets(description, grip(4.0), loop=True)) as emulator:
        recorder = start("record", "-p", emulator.port, "-a", array, "-o", mcap, "--seconds", "30")
        try:
            resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (ROOM, ROOM))
            _, errors = recorder.communicate(timeout=60)
        finally:
            recorder.kill()
    assert recorder.returncode == 2, errors
    assert "ended: File too large" in errors
    assert "Traceback" not in errors
    assert np.isclose(mcap.stat().st_size, ROOM, atol=20_000)
    check_readable(mcap, 50)
