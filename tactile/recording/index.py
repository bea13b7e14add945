"""Indexed recordings: chunked and compressed, so that viewers can jump in them."""

from importlib.metadata import version
from pathlib import Path
from typing import Any

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from cnnsim.support import InputError
from tactile.core.source import Source
from tactile.recording.reader import open_recording, records
from tactile.recording.writer import Recording
from tactile.wire.packets import emulated_description


def write_indexed(source: Path, target: Path) -> None:
    """Copy a recording, whole or broken off, record by record into the indexed form.

    Raises:
        InputError: ``source`` is no recording.
        OSError: ``target`` cannot be written.
    """
    open_recording(source)
    with target.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start("", f"cellular-wave-touch {version('cellular-wave-touch')}")
        schemas: dict[int, int] = {0: 0}
        channels: dict[int, int] = {}
        for record in records(source):
            _copy(writer, record, schemas, channels)
        writer.finish()  # type: ignore[no-untyped-call]  # the library left its types out


def _copy(writer: Writer, record: Any, schemas: dict[int, int], channels: dict[int, int]) -> None:
    if isinstance(record, Schema) and record.id not in schemas:
        schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
    elif isinstance(record, Channel) and record.id not in channels:
        encoding, kind = record.message_encoding, schemas[record.schema_id]
        channels[record.id] = writer.register_channel(record.topic, encoding, kind, record.metadata)
    elif isinstance(record, Message):
        writer.add_message(
            channels[record.channel_id], record.log_time, record.data, record.publish_time, record.sequence
        )
    elif isinstance(record, Metadata):
        writer.add_metadata(record.name, record.metadata)
    elif isinstance(record, Attachment):
        writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)


def write_frames(path: Path, source: Source) -> None:
    """Write frames that never were on a wire; their array description is made up for the native format.

    Raises:
        InputError: the file cannot be written.
    """
    description = emulated_description("native", source)
    recording = Recording(path, description, {"made_from": source.title}, indexed=True)
    for frame in source:
        recording.frame(frame, round(frame.t * 1e9))
        recording.push()
    recording.close({})
    if recording.failed:
        raise InputError(recording.failed)
