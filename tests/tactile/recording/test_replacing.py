"""Existing files are not overwritten without --replace, and are replaced only when the new file is complete."""

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

from tactile.recording.reader import open_recording
from tactile.serial.emulator import Emulator
from tactile.wire.packets import packets
from tests.kits.processes import start, wait_until
from tests.kits.serial import GRIP, call, device, grip, sent, write_array
from tests.tactile.recording.test_reader import recorded

TAKEN = "there is something of that name; another name or --replace wanted"
IN_USE = "another program is writing or sending it; another name wanted"


def refused(result: Result, message: str, path: Path, before: bytes) -> None:
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert path.read_bytes() == before
    assert [other.name for other in path.parent.iterdir() if other.name.startswith(".")] == []


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    recorded(tmp_path / "kept.mcap", seconds=0.1)
    return tmp_path / "kept.mcap"


@pytest.mark.parametrize(("command", "option"), [("record", "-o"), ("live", "--record")])
def test_an_existing_recording_is_replaced_only_on_request(
    tmp_path: Path, kept: Path, command: str, option: str
) -> None:
    before = kept.read_bytes()
    description, stream = sent("native", 0.2)
    array = write_array(tmp_path, description.text)
    with device(stream) as emulator:
        refused(call(command, "-p", emulator.port, "-a", array, option, kept), TAKEN, kept, before)
    for more in ((), ("--replace",)):  # the port cannot be opened
        result = call(command, "-p", tmp_path / "none", "-a", array, option, kept, *more)
        refused(result, "there is no such port" if more else TAKEN, kept, before)
    new = tmp_path / "new.mcap"
    assert call(command, "-p", tmp_path / "none", "-a", array, option, new).exit_code == 2
    assert not new.exists()
    with device(stream) as emulator:
        done = call(command, "-p", emulator.port, "-a", array, option, kept, "--once", "--replace")
    assert done.exit_code == 0, done.output
    again = open_recording(kept)
    assert (again.complete, again.messages["/frames/left"]) == (True, 40)
    assert [other.name for other in tmp_path.iterdir() if other.name.startswith(".")] == []


def test_a_recording_that_cannot_start_leaves_the_old_file(
    tmp_path: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk is full before the header is written."""
    before = kept.read_bytes()
    description, stream = sent("native", 0.2)
    array = write_array(tmp_path, description.text)

    def full(file: int, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    with device(stream) as emulator:
        monkeypatch.setattr("tactile.recording.durable.os.write", full)
        result = call("record", "-p", emulator.port, "-a", array, "-o", kept, "--replace")
        refused(result, f"cannot write the recording {kept}: No space left on device", kept, before)
        result = call("record", "-p", emulator.port, "-a", array, "-o", tmp_path / "new.mcap")
        assert result.exit_code == 2
        assert not (tmp_path / "new.mcap").exists()


def test_recordings_in_use_are_locked(tmp_path: Path, kept: Path) -> None:
    description, _ = sent("native", 0.1)
    array, running, link = write_array(tmp_path, description.text), tmp_path / "running.mcap", tmp_path / "skin"
    with device(packets(description, grip(4.0), loop=True)) as emulator:
        recorder = start("record", "-p", emulator.port, "-a", array, "-o", running)
        try:
            wait_until(lambda: running.exists() and running.stat().st_size > 20_000)
            os.kill(recorder.pid, signal.SIGSTOP)  # the file no longer changes
            before = running.read_bytes()
            refused(call("convert", kept, running, "--replace"), IN_USE, running, before)
            with device([]) as other:
                again = call("record", "-p", other.port, "-a", array, "-o", running, "--replace")
            refused(again, IN_USE, running, before)
            sending = call("emulate", "--recording", running)
            assert (sending.exit_code, "still being recorded" in sending.stderr) == (2, True)
        finally:
            recorder.kill()
            recorder.communicate()
    before = kept.read_bytes()
    sender = start("emulate", "--recording", kept, "--link", link)
    try:
        wait_until(link.is_symlink)
        refused(call("record", "-p", link, "-a", array, "-o", kept, "--replace"), IN_USE, kept, before)
    finally:
        sender.kill()
        sender.communicate()


def test_a_link_replaces_only_a_stale_link_of_an_emulator(tmp_path: Path) -> None:
    taken = "the name is taken; another name wanted"
    notes, folder = tmp_path / "notes.txt", tmp_path / "folder"
    notes.write_text("mine")
    folder.mkdir()
    pointer = tmp_path / "pointer"
    pointer.symlink_to(notes)
    for path in (notes, folder, pointer):
        result = call("emulate", "--protocol", "native", "--scene", GRIP, "--link", path, "--write-array",
                      tmp_path / "a.toml")  # fmt: skip
        assert (result.exit_code, taken in result.stderr) == (2, True), result.output
        assert not (tmp_path / "a.toml").exists()
    assert (notes.read_text(), folder.is_dir(), pointer.readlink()) == ("mine", True, notes)
    stale = tmp_path / "left"
    stale.symlink_to("/dev/pts/none-any-more")
    first = Emulator(link=stale)
    with pytest.raises(Exception, match=taken):
        Emulator(link=stale)  # the first one still runs
    stale.unlink()
    stale.write_text("a newer file")
    first.pull()
    assert stale.read_text() == "a newer file"


def test_a_description_does_not_overwrite_another_file(tmp_path: Path) -> None:
    array, link = tmp_path / "a.toml", tmp_path / "skin"
    array.write_text("mine")
    result = call("emulate", "--protocol", "native", "--scene", GRIP, "--link", link, "--write-array", array)
    assert (result.exit_code, "the name is taken" in result.stderr) == (2, True)
    assert array.read_text() == "mine"
    assert not os.path.lexists(link)
    array.unlink()
    for _ in range(2):  # the second time the file has the same content
        emulator = start("emulate", "--protocol", "csv", "--scene", GRIP, "--link", link, "--write-array", array)
        wait_until(lambda: os.path.lexists(link))  # the signal handler is installed
        emulator.send_signal(signal.SIGTERM)
        assert "sent 0 packets" in emulator.communicate(timeout=20)[1]
        assert not os.path.lexists(link)
        assert "csv" in array.read_text()


def test_conversions_do_not_overwrite_and_leave_no_partial_file(
    tmp_path: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("r.csv", "r.npz", "r.parquet", "r.mcap"):
        target = tmp_path / name
        target.write_bytes(b"mine")
        refused(call("convert", kept, target), TAKEN, target, b"mine")
        assert call("convert", kept, target, "--replace").exit_code == 0
        assert target.read_bytes() != b"mine"
    (tmp_path / "folder.csv").mkdir()
    result = call("convert", kept, tmp_path / "folder.csv", "--replace")
    assert (result.exit_code, "no plain file" in result.stderr) == (2, True)

    def broken(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tactile.sources.convert.write_csv", broken)
    monkeypatch.setitem(__import__("tactile.sources.convert", fromlist=["x"]).WRITERS, ".csv", broken)
    before = (tmp_path / "r.csv").read_bytes()
    refused(call("convert", kept, tmp_path / "r.csv", "--replace"), "No space left", tmp_path / "r.csv", before)
