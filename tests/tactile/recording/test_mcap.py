"""Recordings by the MCAP library: check sums, seeking and streaming, JSON messages and their schemas, the log."""

import json
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.records import (
    Chunk,
    Message,
)
from mcap.stream_reader import StreamReader, breakup_chunk

from tactile.recording.reader import open_recording
from tactile.wire.packets import emulated_description, packets
from tests.kits.serial import call, device, grip, later

TYPES: dict[str, Any] = {
    "string": str, "number": (int, float), "integer": int, "boolean": bool, "object": dict, "array": list,
}  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A live recording with a tare and events, its indexed copy, and a recording converted from CSV."""
    folder = tmp_path_factory.mktemp("mcap")
    scene = later(grip(2.0), 0.7)  # 0.5 s without contact for the tare, then the grip
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
    """Return all records, with chunks replaced by the records that they contain."""
    out: list[Any] = []
    for record in records:
        out += breakup_chunk(record, validate_crc=True) if isinstance(record, Chunk) else [record]
    return out


NAMES = pytest.mark.parametrize("name", ["live", "indexed", "frames"])


@NAMES
def test_seeking_and_streaming_give_the_same_messages(files: dict[str, Path], name: str) -> None:
    streamed = [record for record in unpacked(read(files[name])) if isinstance(record, Message)]
    with files[name].open("rb") as file:
        indexed = [message for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]
    key = [(message.log_time, message.channel_id, message.data) for message in streamed]
    assert sorted(key) == sorted((message.log_time, message.channel_id, message.data) for message in indexed)
    assert [message.log_time for message in indexed] == sorted(message.log_time for message in indexed)


@NAMES
def test_json_messages_match_their_schemas(files: dict[str, Path], name: str) -> None:
    seen, checked = set(), 0
    with files[name].open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.message_encoding == "json":
                assert schema is not None
                check_schema(json.loads(message.data), json.loads(schema.data), channel.topic)
                checked += 1
                seen.add((channel.topic, schema.name))
    assert checked >= (0 if name == "frames" else 8)
    assert (("/log", "foxglove.Log") in seen) is (name != "frames")
    wanted = set() if name == "frames" else {"/port", "/tare", "/events", "/counts", "/log"}
    assert {topic for topic, _ in seen} == wanted


def check_schema(value: Any, schema: dict[str, Any], where: str) -> None:
    if value is None:
        return
    assert isinstance(value, TYPES[schema["type"]]), where
    if schema["type"] == "array":
        for one in value if "items" in schema else ():
            check_schema(one, schema["items"], where)
    for key in value if {"properties", "additionalProperties"} & set(schema) else ():
        kind = schema.get("properties", {}).get(key) or schema.get("additionalProperties")
        assert kind is not None, f"{where}: {key}"
        check_schema(value[key], kind, f"{where}.{key}")


def test_log_contains_port_and_tare_messages_with_times(files: dict[str, Path]) -> None:
    lines = list(open_recording(files["live"]).notes("/log"))
    messages = [line["message"] for line in lines]
    assert messages[0] == "plugged"
    assert sum(one.startswith("tare taken, at the start: 0.00 ‰ normal") for one in messages) == 2
    start = int(open_recording(files["live"]).made["start_ns"])
    assert all(0 <= line["timestamp"]["sec"] * 10**9 + line["timestamp"]["nsec"] - start < 60e9 for line in lines)
