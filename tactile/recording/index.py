"""Recordings made from files: compressed copies of recordings, and frames without wire bytes."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from tactile.core.epoch import Epoch
from tactile.core.frame import Frame
from tactile.core.header import header_text
from tactile.core.source import Source, provenance
from tactile.recording.reader import COPIED, FRAMES, open_recording
from tactile.recording.records import records
from tactile.recording.schema import OtherMessage, add_other
from tactile.recording.writer import Recording
from tactile.wire.description_file import parse_description
from tactile.wire.packets import emulated_description

Others = Callable[[Iterable[Frame], int], Iterable[OtherMessage]]
"""Makes messages from frames, given the Unix time [ns] at which t is 0."""


def write_indexed(source: Path, target: Path, others: Others | None = None, frames: Iterable[Frame] = ()) -> None:
    """Copy a recording record by record into the compressed form; the copy of a damaged one has the mark of it.

    ``others`` makes further messages from the ``frames`` of the recording.

    Raises:
        InputError: ``source`` is no recording.
        OSError: ``target`` cannot be written.
    """
    recorded = open_recording(source)
    mark = recorded.mark
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start("", f"cellular-wave-touch {version('cellular-wave-touch')}")
        numbers = _described(source, writer)
        for record in records(source):
            if isinstance(record, Message) and record.channel_id in numbers:
                channel = numbers[record.channel_id]
                writer.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
            elif isinstance(record, Metadata):
                if record.name != COPIED:
                    writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Attachment):
                writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
        channels = dict[str, int]()
        for message in () if others is None else others(frames, recorded.start):
            add_other(writer, channels, message)
        if mark:
            writer.add_metadata(COPIED, {"mark": mark})
        writer.finish()  # type: ignore[no-untyped-call]  # the library left its types out


def _described(source: Path, writer: Writer) -> dict[int, int]:
    """Register the channels found anywhere in the file, and return the new number of each."""
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    for record in records(source):
        if isinstance(record, Schema) and record.id not in schemas:
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel) and record.id not in channels and record.schema_id in schemas:
            encoding, kind = record.message_encoding, schemas[record.schema_id]
            channels[record.id] = writer.register_channel(record.topic, encoding, kind, record.metadata)
    return channels


def write_frames(path: Path, source: Source, others: Others | None = None) -> None:
    """Write frames without wire bytes, with the header of `tactile.core.header` as ``frames`` of the metadata.

    A source without an array description gets one for the native format. ``others`` makes further messages.

    Raises:
        InputError: the name is taken.
        OSError: the file cannot be written.
    """
    known, epoch = provenance(source), Epoch.now()
    if known.start_ns is not None:
        epoch = replace(epoch, unix=known.start_ns)
    if known.description:
        description = parse_description(known.description, "array description")
    else:
        description = emulated_description("native", source)
    origin = {"made_from": source.title, FRAMES: header_text(source)}
    recording = Recording(path, description, origin, epoch, compressed=True)

    def written() -> Iterator[Frame]:
        for frame in source:
            recording.frame(frame, max(0, round(frame.t * 1e9)))
            recording.push()
            yield frame

    if others is None:
        for _ in written():
            pass
    else:
        for message in others(written(), epoch.unix):
            recording.other(message)
    recording.close({})
    if recording.failed:
        raise OSError(0, recording.failed)
