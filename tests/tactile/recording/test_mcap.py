"""Recordings held to the MCAP specification: every record, offset, count, time and check sum, and what schemas say."""

import json
import struct
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Header,
    Message,
    MessageIndex,
    Metadata,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.well_known import MessageEncoding, SchemaEncoding

from tactile.recording.reader import open_recording
from tactile.wire.packets import emulated_description, packets
from tests.kits.serial import call, device, grip

MAGIC = b"\x89MCAP0\r\n"
FOOTER = 8 + 8 + 4
TYPES: dict[str, Any] = {
    "string": str, "number": (int, float), "integer": int, "boolean": bool, "object": dict, "array": list,
}  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A live recording with a tare and events, its indexed copy, and frames that never were on a wire."""
    folder = tmp_path_factory.mktemp("mcap")
    scene = grip(2.0)  # half a second of nothing for the tare, then the grip
    later = [replace(load, path=np.add(load.path, [0.7, 0, 0, 0, 0, 0])) for load in scene.loads]
    scene = replace(scene, loads=tuple(later))
    description = emulated_description("native", scene)
    array = folder / "array.toml"
    array.write_text(description.text, encoding="utf-8")
    live = folder / "live.mcap"
    with device(packets(description, scene)) as emulator:
        done = call("live", "-p", emulator.port, "-a", array, "--record", live, "--once", "--seconds", "20")
    assert done.exit_code == 0, done.output
    call("convert", live, folder / "indexed.mcap")
    call("convert", live, folder / "frames.csv")
    call("convert", folder / "frames.csv", folder / "frames.mcap")
    return {name: folder / f"{name}.mcap" for name in ("live", "indexed", "frames")}


def read(path: Path) -> list[Any]:
    with path.open("rb") as file:
        return list(StreamReader(file, emit_chunks=True, validate_crcs=True).records)


def unpacked(records: list[Any]) -> list[Any]:
    """The records with those inside of chunks in their places."""
    out: list[Any] = []
    for record in records:
        out += breakup_chunk(record, validate_crc=True) if isinstance(record, Chunk) else [record]
    return out


NAMES = pytest.mark.parametrize("name", ["live", "indexed", "frames"])


@NAMES
def test_the_frame_of_the_file(files: dict[str, Path], name: str) -> None:
    whole, records = files[name].read_bytes(), read(files[name])
    assert whole.startswith(MAGIC)
    assert whole.endswith(MAGIC)
    assert isinstance(records[0], Header)
    assert records[0].profile == ""  # not "ros2", which wants CDR on every topic
    assert isinstance(records[-1], Footer)
    assert sum(isinstance(record, DataEnd) for record in records) == 1
    footer = records[-1]
    summary = whole[footer.summary_start : len(whole) - len(MAGIC) - 4]  # all before the sum itself
    assert footer.summary_crc == zlib.crc32(summary) != 0
    at = footer.summary_offset_start
    while whole[at] == 0x0E:  # the groups of the summary are where their offsets say
        length, kind, start, size = struct.unpack_from("<QBQQ", whole, at + 1)
        assert whole[start] == kind
        assert footer.summary_start <= start < start + size <= footer.summary_offset_start
        at += 9 + length
    assert at == len(whole) - len(MAGIC) - 9 - FOOTER


@NAMES
def test_channels_and_schemas_come_first_and_are_known(files: dict[str, Path], name: str) -> None:
    encodings = {getattr(MessageEncoding, key) for key in vars(MessageEncoding) if key[0] != "_"}
    forms = {getattr(SchemaEncoding, key) for key in vars(SchemaEncoding) if key[0] != "_"}
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for record in unpacked(read(files[name])):
        if isinstance(record, Schema):
            assert record.id > 0
            assert record.encoding in forms
            assert schemas.setdefault(record.id, record) == record
            if record.encoding == "jsonschema":
                assert json.loads(record.data)["type"] == "object"
        elif isinstance(record, Channel):
            assert record.schema_id in schemas
            assert record.message_encoding in encodings
            assert (record.message_encoding, schemas[record.schema_id].encoding) in (
                ("cdr", "ros2msg"),
                ("json", "jsonschema"),
            )
            assert channels.setdefault(record.id, record) == record
        elif isinstance(record, Message):
            assert record.channel_id in channels
    assert len({channel.topic for channel in channels.values()}) == len(channels)


@NAMES
def test_statistics_are_true(files: dict[str, Path], name: str) -> None:
    records = read(files[name])
    inside = unpacked(records)
    messages = [record for record in inside if isinstance(record, Message)]
    (told,) = (record for record in records if isinstance(record, Statistics))
    counts = {record.id: 0 for record in inside if isinstance(record, Channel)}
    for message in messages:
        counts[message.channel_id] += 1
    assert told.message_count == len(messages) > 100
    assert {channel: count for channel, count in told.channel_message_counts.items() if count} == {
        channel: count for channel, count in counts.items() if count
    }
    assert told.channel_count == len(counts)
    assert told.schema_count == len({record.id for record in inside if isinstance(record, Schema)})
    assert told.message_start_time == min(message.log_time for message in messages)
    assert told.message_end_time == max(message.log_time for message in messages)
    assert told.chunk_count == sum(isinstance(record, Chunk) for record in records)
    assert told.attachment_count == sum(isinstance(record, Attachment) for record in records) == 1
    assert told.metadata_count == sum(isinstance(record, Metadata) for record in records) == 2


@NAMES
def test_indexes_point_at_what_they_say(files: dict[str, Path], name: str) -> None:
    whole = files[name].read_bytes()
    with files[name].open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None
    places = [(0x09, place.offset, place.length) for place in summary.attachment_indexes]
    places += [(0x0C, place.offset, place.length) for place in summary.metadata_indexes]
    for wanted, offset, size in places:
        kind, length = struct.unpack_from("<BQ", whole, offset)
        assert (kind, length + 9) == (wanted, size)
    assert summary.chunk_indexes
    assert all(set(index.message_index_offsets) <= set(summary.channels) for index in summary.chunk_indexes)
    records = read(files[name])
    chunks = [record for record in records if isinstance(record, Chunk)]
    assert len(chunks) == len(summary.chunk_indexes)
    packed = "" if name == "live" else "zstd"  # a live one must not wait for enough to pack
    for index, chunk in zip(summary.chunk_indexes, chunks, strict=True):
        assert whole[index.chunk_start_offset] == 0x06
        assert (index.message_start_time, index.message_end_time) == (chunk.message_start_time, chunk.message_end_time)
        assert (index.compression, index.uncompressed_size) == (packed, chunk.uncompressed_size)
    inside: dict[int, tuple[int, int]] = {}
    for record in records:  # the message indexes after every chunk
        if isinstance(record, Chunk):
            assert not inside
            inside = _messages(record)
        elif isinstance(record, MessageIndex):
            for time, offset in record.records:
                assert inside.pop(offset) == (record.channel_id, time)
    assert not inside


def _messages(chunk: Chunk) -> dict[int, tuple[int, int]]:
    """Offset in the chunk's own bytes -> channel and time of every message there, read by hand."""
    data = zstandard.decompress(chunk.data, chunk.uncompressed_size) if chunk.compression else chunk.data
    at, found = 0, {}
    while at < len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        if kind == 0x05:
            channel, _, time = struct.unpack_from("<HIQ", data, at + 9)
            found[at] = channel, time
        at += 9 + length
    return found


@NAMES
def test_seeking_and_streaming_agree(files: dict[str, Path], name: str) -> None:
    streamed = [record for record in unpacked(read(files[name])) if isinstance(record, Message)]
    with files[name].open("rb") as file:
        sought = [message for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]
    key = [(message.log_time, message.channel_id, message.data) for message in streamed]
    assert sorted(key) == sorted((message.log_time, message.channel_id, message.data) for message in sought)
    assert [message.log_time for message in sought] == sorted(message.log_time for message in sought)


@NAMES
def test_notes_are_what_their_schemas_say(files: dict[str, Path], name: str) -> None:
    seen = set()
    with files[name].open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.message_encoding == "json":
                assert schema is not None
                fits(json.loads(message.data), json.loads(schema.data), channel.topic)
                seen.add((channel.topic, schema.name))
    if name != "frames":
        assert ("/log", "foxglove.Log") in seen
        assert {topic for topic, _ in seen} == {"/port", "/tare", "/events", "/counts", "/log"}


def fits(value: Any, schema: dict[str, Any], where: str) -> None:
    if value is None:
        return
    assert isinstance(value, TYPES[schema["type"]]), where
    if schema["type"] == "array":
        for one in value if "items" in schema else ():
            fits(one, schema["items"], where)
    for key in value if {"properties", "additionalProperties"} & set(schema) else ():
        kind = schema.get("properties", {}).get(key) or schema.get("additionalProperties")
        assert kind is not None, f"{where}: {key}"
        fits(value[key], kind, f"{where}.{key}")


def test_a_log_of_what_happened(files: dict[str, Path]) -> None:
    lines = list(open_recording(files["live"]).notes("/log"))
    said = [line["message"] for line in lines]
    assert said[0] == "plugged"
    assert sum(one.startswith("tare taken, at the start: 0.00 ‰ normal") for one in said) == 2
    start = int(open_recording(files["live"]).made["start_ns"])
    assert all(0 <= line["timestamp"]["sec"] * 10**9 + line["timestamp"]["nsec"] - start < 60e9 for line in lines)
