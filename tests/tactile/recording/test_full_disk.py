"""Recording until a real file system is full, or a file may not grow: a message, and all until then can be read."""

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
    """A file system of its own in memory, where this machine lets us mount one."""
    path.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", str(path)]
    try:
        done = subprocess.run(mount, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("there is no mount command here")
    if done.returncode:
        pytest.skip(f"no small file system can be mounted here: {done.stderr.strip()}")
    try:
        yield path
    finally:
        subprocess.run(["umount", "-l", str(path)], check=False)


def check_what_is_left(path: Path, least: int) -> None:
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
        assert "good, 0 bad checksum" in result.stdout  # the counters all the same
        assert ROOM / 2 < mcap.stat().st_size <= ROOM
        assert os.statvfs(disk).f_bavail <= 12  # pages of 4 KiB: what was taken back
        check_what_is_left(mcap, 50)


def test_what_is_converted_onto_a_full_disk_is_a_message(tmp_path: Path) -> None:
    description, stream = sent("native", 4.0)
    array, mcap = tmp_path / "array.toml", tmp_path / "r.mcap"
    array.write_text(description.text, encoding="utf-8")
    with device(((t / 20, data) for t, data in stream)) as emulator:
        assert call("record", "-p", emulator.port, "-a", array, "-o", mcap, "--once").exit_code == 0
    with small_disk(tmp_path / "disk") as disk:
        (disk / "filler").write_bytes(bytes(ROOM - 4096))
        for name in ("r.csv", "r.npz", "r.parquet", "r.mcap"):
            result = call("convert", mcap, disk / name)
            assert result.exit_code == 2, (name, result.output, result.exception)
            assert "No space left on device" in result.stderr, (name, result.stderr)
            (disk / name).unlink(missing_ok=True)
        result = call("emulate", "--recording", mcap, "--write-array", disk / "no" / "a.toml")
        assert (result.exit_code, "cannot write" in result.stderr) == (2, True)


def test_a_file_that_may_not_grow_ends_the_recording_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A limit on the size of files needs no rights; the kernel's signal for it must not kill the recorder."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # modules would be kept cut off
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
    check_what_is_left(mcap, 50)
