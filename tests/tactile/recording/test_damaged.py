"""Damaged recordings: intact readings are returned unchanged, and the damage is reported."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Attachment, Metadata
from mcap.writer import Writer

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.core.frame import Frame
from tactile.live_options import LiveOptions
from tactile.recording import schema
from tactile.recording.reader import Recorded, open_recording
from tactile.recording.records import records
from tactile.recording.writer import Recording
from tactile.sources import open_source
from tactile.wire.source import DAMAGED, WireSource
from tests.kits.paths import SCENES
from tests.kits.serial import call, sent
from tests.kits.touch.one_finger import run_command
from tests.tactile.recording.test_reader import recorded, same

SCENE = SCENES / "needle.toml"
KINDS = ["live", "broken off", "converted", "frames"]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A closed live recording of a format without check sums, the same not closed, its copy, and a scene's frames."""
    folder = tmp_path_factory.mktemp("damaged")
    recorded(folder / "live.mcap", "reskin", 0.12)
    recorded(folder / "broken off.mcap", "reskin", 0.12, close=False)
    call("convert", folder / "live.mcap", folder / "converted.mcap")
    call("convert", SCENE, folder / "frames.mcap")
    return {name: (folder / f"{name}.mcap").read_bytes() for name in KINDS}


def read(file: Path) -> list[Frame]:
    return list(open_recording(file).source())


@pytest.mark.parametrize("kind", ["changed", "lost", "added"])
@pytest.mark.parametrize("name", KINDS)
def test_damaged_files_are_read_or_refused_with_an_input_error(
    files: dict[str, bytes], tmp_path: Path, name: str, kind: str
) -> None:
    file, random, whole = tmp_path / "damaged.mcap", np.random.default_rng(1), files[name]
    file.write_bytes(whole)
    frames = len(read(file))
    assert frames > 20
    places = [*range(8, 2500, 97), *random.integers(2500, len(whole), 15).tolist()]
    for place in places:
        old = whole[place : place + 1]
        middle = {"changed": bytes([old[0] ^ 0x81]), "lost": b"", "added": old + b"\x9c"}[kind]
        file.write_bytes(whole[:place] + middle + whole[place + 1 :])
        with suppress(InputError):
            assert len(read(file)) <= frames


def flip(whole: bytes, bit: int) -> bytes:
    data = bytearray(whole)
    data[bit // 8] ^= 1 << bit % 8
    return bytes(data)


@pytest.mark.parametrize("name", KINDS)
def test_a_flipped_bit_gives_no_wrong_reading(files: dict[str, bytes], tmp_path: Path, name: str) -> None:
    """For about 300 bits, the readings returned are a subset of those written, and the file is not complete."""
    file, whole = tmp_path / "flipped.mcap", files[name]
    file.write_bytes(whole)
    truth = {(frame.finger, frame.values.tobytes()) for frame in read(file)}
    stored = {(frame.finger, frame.t, frame.values.tobytes()) for frame in open_recording(file).stored_frames()}
    assert open_recording(file).complete == (name != "broken off")
    bits = np.random.default_rng(2).choice(8 * len(whole), 240 if name == "live" else 60, replace=False).tolist()
    bits += range(8 * len(whole) - 8 * 12, 8 * len(whole), 8)
    bits += np.random.default_rng(3).integers(0, 8 * 1200, 60).tolist()  # metadata and description
    counts, errors = [], 0
    for bit in bits:
        file.write_bytes(flip(whole, bit))
        try:
            again = open_recording(file)
            got, kept = list(again.source()), list(again.stored_frames())
        except InputError as error:
            assert "damaged" in str(error) or "not a recording" in str(error) or "version" in str(error)
            errors += 1
            continue
        assert not again.complete, bit
        assert again.state, bit
        assert {(frame.finger, frame.values.tobytes()) for frame in got} <= truth, bit
        assert {(frame.finger, frame.t, frame.values.tobytes()) for frame in kept} <= stored, bit
        counts.append(len(got))
    assert errors < 90
    assert np.mean(counts) > len(truth) / 3  # intact chunks are still read


def damaged_in_the_middle(tmp_path: Path) -> tuple[list[Frame], Recorded]:
    """Return a recording's frames, and the recording with one bit flipped in a middle chunk of wire bytes."""
    recorded(tmp_path / "r.mcap", "native", 0.5)
    with (tmp_path / "r.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    wire = [index.chunk_start_offset for index in summary.chunk_indexes if 1 in index.message_index_offsets]
    whole = (tmp_path / "r.mcap").read_bytes()
    (tmp_path / "d.mcap").write_bytes(flip(whole, 8 * (wire[len(wire) // 2] + 100)))
    return read(tmp_path / "r.mcap"), open_recording(tmp_path / "d.mcap")


def test_damaged_chunks_are_reported_and_conversion_repairs_the_file(tmp_path: Path) -> None:
    frames, again = damaged_in_the_middle(tmp_path)
    assert not again.complete
    assert any("the chunk at byte" in what for what in again.damage)
    assert [chunk.note for chunk in again.chunks()].count(DAMAGED) >= 1
    got = list(again.source())
    assert 0 < len(got) < len(frames)
    assert again.counts is not None
    replayed = call("replay", tmp_path / "d.mcap")
    assert "damaged: the chunk at byte" in replayed.stdout
    call("convert", tmp_path / "d.mcap", tmp_path / "healed.mcap")
    healed = open_recording(tmp_path / "healed.mcap")
    assert healed.complete
    same(list(healed.source()), got)


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet", ".mcap"])
def test_copies_of_a_damaged_recording_repeat_its_damage(tmp_path: Path, suffix: str) -> None:
    frames, again = damaged_in_the_middle(tmp_path)
    what = f"d.mcap: damaged: {again.damage[0]}"
    copy, second = tmp_path / f"copy{suffix}", tmp_path / "second.mcap"
    assert what in call("convert", again.path, copy).stderr
    for result in (call("convert", copy, second), call("emulate", "--scene", second), call("calibrate", second)):
        assert f"made from {what}" in result.stderr or result.exit_code == 2, result.stderr
    with pytest.warns(UserWarning, match="second.mcap: made from d.mcap: damaged"):
        source = open_source(second)
    same(list(source), list(again.source()))
    assert len(list(source)) < len(frames)


def test_a_recording_of_wire_bytes_gives_its_frames_and_counters_again(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap", "native", 0.3)
    source = open_recording(tmp_path / "r.mcap").source()
    assert isinstance(source, WireSource)
    first, counts = list(source), source.counts.plain()
    same(list(source), first)
    assert source.counts.plain() == counts
    same([frame for pair in zip(source, source, strict=True) for frame in pair][::2], first)


def test_an_unclosed_recording_names_the_command_that_repairs_it(files: dict[str, bytes], tmp_path: Path) -> None:
    file = tmp_path / "killed.mcap"
    file.write_bytes(files["broken off"])
    replayed = call("replay", file)
    assert "not closed in good order" in replayed.stdout, replayed.output
    assert "`tactile convert killed.mcap whole.mcap`" in replayed.stdout
    assert "killed.mcap: not closed in good order" in run_command(file).stderr.replace("\n", " ")
    call("convert", file, tmp_path / "whole.mcap")
    whole = open_recording(tmp_path / "whole.mcap")
    assert whole.complete
    same(list(whole.source()), read(file))


def with_metadata(tmp_path: Path, **made: str | None) -> Path:
    """Return a recording with changed metadata and a matching check sum."""
    source, target = tmp_path / "source.mcap", tmp_path / "changed.mcap"
    description, _ = sent("native", 0.1)
    Recording(source, description, {"choices": LiveOptions().text()}, Epoch.now(), replace=True).close({})
    with target.open("wb") as file:
        writer = Writer(file, enable_data_crcs=True)
        writer.start()
        for record in records(source):
            if isinstance(record, Metadata) and record.name == "tactile":
                table = {name: value for name, value in (record.metadata | made).items() if value is not None}
                table.pop(schema.SUM)
                writer.add_metadata("tactile", table | {schema.SUM: schema.sum_of(table)})
            elif isinstance(record, Attachment):
                writer.add_attachment(0, 0, record.name, record.media_type, record.data)
        writer.add_message(writer.register_channel("/wire", "cdr", 0), 1, schema.pack_wire(b"x"), 1)
        writer.finish()  # type: ignore[no-untyped-call]
    return target


@pytest.mark.parametrize(("made", "message"), [
    ({"start_ns": "soon"}, "damaged: invalid literal"),
    ({"start_ns": None}, "damaged: 'start_ns'"),
    ({"version": "3"}, "a recording of version 3; this program reads version 2"),
    ({"version": None}, "a recording of version None"),
    ({"choices": "{"}, "choices of the live run: damaged"),
    ({"choices": "[1]"}, "a table wanted"),
    ({"choices": '{"tare": "auto", "gravity": 9.81}'}, "unknown key 'gravity'"),
    ({"choices": '{"tare": "sometimes"}'}, "tare = 'sometimes'; one of auto, manual, off wanted"),
    ({"choices": '{"window": "128"}'}, "window = '128', a whole number wanted"),
    ({"choices": '{"dead_band": NaN}'}, "dead_band = nan, a finite number wanted"),
    ({"choices": '{"sign_code": 1}'}, "sign_code = 1, true or false wanted"),
    ({"choices": '{"backend": "abacus"}'}, "backend = 'abacus'"),
])  # fmt: skip
def test_invalid_metadata_is_refused_in_one_line(tmp_path: Path, made: dict[str, str | None], message: str) -> None:
    result = call("replay", with_metadata(tmp_path, **made))
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert result.stderr.count("\n") <= 1
    assert call("replay", with_metadata(tmp_path)).exit_code == 0
