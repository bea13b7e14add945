"""Reading of MCAP recordings, whole ones and those whose writer was killed."""

import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Footer, Message, Metadata
from mcap.stream_reader import CRCValidationError, StreamReader
from zstandard import ZstdError

from cnnsim.support import InputError
from tactile.core.frame import Frame, TaxelArray
from tactile.recording import schema
from tactile.wire.description import Description
from tactile.wire.description_file import parse_description
from tactile.wire.source import Chunk, WireSource


@dataclass
class Recorded:
    """A recording on disk, read again from the beginning each time.

    ``made``: with what it was made; ``counts``: the counters, None where it was not closed in good order.
    """

    path: Path
    description: Description
    made: dict[str, str]
    counts: dict[str, Any] | None = None
    has_wire: bool = False
    complete: bool = False
    messages: dict[str, int] = field(default_factory=dict)

    def chunks(self) -> Iterator[Chunk]:
        """Yield what came over the wire, as the reader that recorded it gave it on."""
        start = int(self.made["start_ns"])
        for topic, message in self._messages():
            with readable(self.path):
                if topic == "/wire":
                    chunk = Chunk(message.log_time - start, schema.unpack_wire(message.data))
                elif topic == "/port":
                    chunk = Chunk(message.log_time - start, note=json.loads(message.data)["note"])
                else:
                    continue
            yield chunk

    def stored_frames(self) -> Iterator[Frame]:
        """Yield the frames as they were written, before their tare."""
        for topic, message in self._messages():
            if topic.startswith("/frames/"):
                with readable(self.path):
                    frame = schema.unpack_frame(message.data)
                yield frame

    def notes(self, topic: str) -> Iterator[dict[str, Any]]:
        """Yield the JSON objects of a topic."""
        for name, message in self._messages():
            if name == topic:
                with readable(self.path):
                    note = json.loads(message.data)
                yield note

    def source(self) -> "WireSource | StoredSource":
        """Return the frames before their tare as a ``Source``: decoded anew from the bytes where there are any."""
        return WireSource(self.description, self.chunks()) if self.has_wire else StoredSource(self)

    def _messages(self) -> Iterator[tuple[str, Message]]:
        topics: dict[int, str] = {}
        for record in records(self.path):
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message):
                yield topics[record.channel_id], record


class StoredSource:
    """The stored frames of a recording without bytes, as a ``Source``."""

    def __init__(self, recorded: Recorded) -> None:
        self._recorded = recorded
        self.title = recorded.description.title
        self.arrays: tuple[TaxelArray, ...] = recorded.description.arrays
        self.modulus, self.frames = recorded.description.modulus, None

    def __iter__(self) -> Iterator[Frame]:
        return self._recorded.stored_frames()


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Say of what stands in a record and cannot be read that the recording is damaged."""
    try:
        yield
    except (ValueError, LookupError, TypeError, OverflowError, struct.error) as error:
        raise InputError(f"{path}: damaged: {error}") from error


def records(path: Path) -> Iterator[Any]:
    """Yield the records of an MCAP file up to its end or the place where it breaks off."""
    channels = set()
    try:
        with path.open("rb") as file:
            for record in StreamReader(file, record_size_limit=2**28).records:
                if isinstance(record, Channel):
                    channels.add(record.id)
                elif isinstance(record, Message) and record.channel_id not in channels:
                    return  # damaged here
                yield record
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except (McapError, CRCValidationError, ZstdError, struct.error, ValueError, OverflowError, MemoryError):
        return  # the writer was stopped here, or a length is damaged


def open_recording(path: Path) -> Recorded:
    """Look through a recording.

    Raises:
        InputError: no such file, or nothing that `tactile record` or `tactile live` wrote.
    """
    made: dict[str, str] = {}
    counts, text, complete = None, None, False
    topics: dict[int, str] = {}
    messages: dict[str, int] = {}
    for record in records(path):
        if isinstance(record, Message):
            topic = topics[record.channel_id]
            messages[topic] = messages.get(topic, 0) + 1
        elif isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Metadata) and record.name == "tactile":
            made = record.metadata
        elif isinstance(record, Metadata) and record.name == "counts":
            with readable(path):
                counts = {name: json.loads(value) for name, value in record.metadata.items()}
        elif isinstance(record, Attachment) and record.name == "array.toml":
            with readable(path):
                text = record.data.decode()
        complete = complete or isinstance(record, Footer)
    if text is None or "start_ns" not in made:
        raise InputError(f"{path}: not a recording of this program: an MCAP file with array.toml attached wanted")
    description = parse_description(text, f"{path}: array.toml")
    return Recorded(path, description, made, counts, "/wire" in messages, complete, messages)
