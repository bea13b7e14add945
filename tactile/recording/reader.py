"""Reader of recordings: complete ones, interrupted ones and damaged ones."""

import json
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

from mcap.records import Attachment, Channel, Message, Metadata

from cnnsim.support import InputError
from tactile.core.frame import Frame
from tactile.core.header import RecordingHeader, read_header
from tactile.core.source import UNCLOSED, ForeignFileError, Provenance
from tactile.recording import schema
from tactile.recording.records import Closed, Damage, records
from tactile.wire.description import Description
from tactile.wire.description_file import parse_description
from tactile.wire.source import DAMAGED, Chunk, WireSource

FRAMES = "frames"
"""Metadata entry with the header of frames without wire bytes."""
COPIED = "copied"
"""Metadata entry of a copy of a damaged recording: its ``mark``."""
FIRST = 4
"""Frames per finger that are checked against the header when a recording is opened."""


@dataclass
class Recorded:
    """A recording on disk, read from the beginning each time; an iterable of its `chunks`.

    ``made``: settings it was made with; ``start`` [ns] Unix time at which times are 0; ``counts``: the counters, None
    if it was not closed; ``damage``: descriptions of unreadable parts; ``complete``: it was closed and every checksum
    is right; ``topics`` of the channels; ``copied``: of a copy, the `mark` of its damaged original.
    """

    path: Path
    description: Description
    made: dict[str, str]
    start: int
    counts: dict[str, Any] | None = None
    damage: tuple[str, ...] = ()
    complete: bool = False
    messages: dict[str, int] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)
    copied: str = ""

    @property
    def has_wire(self) -> bool:
        """Whether it contains wire bytes."""
        return "/wire" in self.messages

    @property
    def state(self) -> str:
        """One line about what is wrong with it; empty if it is complete."""
        if self.damage:
            more = f", and {len(self.damage) - 1} more of this kind" if len(self.damage) > 1 else ""
            return f"damaged: {self.damage[0]}{more}; only parts with a right checksum are used"
        if not self.complete:
            return UNCLOSED
        return ""

    @property
    def mark(self) -> str:
        """Names of this and of the copied recording with their `state`, for its copies; empty if both are complete."""
        return "; ".join(filter(None, (f"{self.path.name}: {self.state}" if self.state else "", self.copied)))

    def chunks(self) -> Iterator[Chunk]:
        """Yield the chunks of wire bytes as recorded, with a mark where some are missing."""
        t = 0
        for record in records(self.path):
            if isinstance(record, Damage):
                yield Chunk(t, note=DAMAGED)
                continue
            topic = self._topic(record)
            with readable(self.path):
                if topic == "/wire":
                    chunk = Chunk(record.log_time - self.start, schema.unpack_wire(record.data))
                elif topic == "/port":
                    chunk = Chunk(record.log_time - self.start, note=json.loads(record.data)["note"])
                else:
                    continue
            t = chunk.t
            yield chunk

    __iter__ = chunks

    def stored_frames(self) -> Iterator[Frame]:
        """Yield the stored frames, before their tare."""
        for record in records(self.path):
            if self._topic(record).startswith("/frames/"):
                with readable(self.path):
                    frame = schema.unpack_frame(record.data)
                yield frame

    def notes(self, topic: str) -> Iterator[dict[str, Any]]:
        """Yield the JSON objects of a topic."""
        for record in records(self.path):
            if self._topic(record) == topic:
                with readable(self.path):
                    note = json.loads(record.data)
                yield note

    def source(self) -> "WireSource | StoredSource":
        """Return the frames before their tare as a ``Source``, decoded from the wire bytes if there are any."""
        if not self.has_wire:
            return StoredSource(self)
        source = WireSource(self.description, self)
        choices = self.made.get("choices", "")
        source.provenance = replace(source.provenance, start_ns=self.start, choices=choices, damage=self.mark)
        return source

    def _topic(self, record: Any) -> str:
        """Return the topic of a message, nothing for other records and where nothing describes its channel."""
        return self.topics.get(record.channel_id, "") if isinstance(record, Message) else ""


class StoredSource:
    """The stored frames of a recording without wire bytes, as a ``Source``.

    Raises:
        InputError: its header does not fit its first frames; iteration raises it for later frames.
    """

    def __init__(self, recorded: Recorded) -> None:
        self._recorded = recorded
        description = recorded.description
        header = RecordingHeader(description.title, description.modulus, description.arrays, Provenance())
        if FRAMES in recorded.made:
            header = read_header(recorded.made[FRAMES], str(recorded.path), "metadata frames")
        self.title, self.modulus, self.arrays, known = header
        self.provenance = replace(known, damage="; ".join(filter(None, (recorded.mark, known.damage))))
        self.frames: int | None = sum(n for topic, n in recorded.messages.items() if topic.startswith("/frames/"))
        for _ in islice(self, FIRST * len(self.arrays)):  # before memory is allocated for the header's sizes
            pass

    def __repr__(self) -> str:
        return f"StoredSource({self.title!r}, {len(self.arrays)} fingers, {self.frames} frames)"

    def __iter__(self) -> Iterator[Frame]:
        path, shapes = self._recorded.path, [array.shape for array in self.arrays]
        for frame in self._recorded.stored_frames():
            if frame.finger >= len(shapes):
                raise InputError(f"{path}: damaged: a frame of finger {frame.finger}, {len(shapes)} in its header")
            if frame.valid.shape != shapes[frame.finger]:
                there, told = (" x ".join(map(str, shape)) for shape in (frame.valid.shape, shapes[frame.finger]))
                raise InputError(f"{path}: damaged: a frame of {there} taxels, {told} in its header")
            yield frame


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turn a decoding error of a record into a message about a damaged recording."""
    try:
        yield
    except (ValueError, LookupError, TypeError, OverflowError, struct.error) as error:
        raise InputError(f"{path}: damaged: {error}") from error


def open_recording(path: Path) -> Recorded:
    """Open a recording and check it.

    Raises:
        InputError: no such file, a file that `tactile record` or `tactile live` did not write, a newer version, or a
            damaged header.
    """
    made: dict[str, str] = {}
    counts, data, closed, copied = None, None, False, ""
    topics: dict[int, str] = {}
    numbers: dict[int, int] = {}
    damage = []
    for record in records(path):
        if isinstance(record, Message):
            numbers[record.channel_id] = numbers.get(record.channel_id, 0) + 1
        elif isinstance(record, Channel):
            topics.setdefault(record.id, record.topic)
        elif isinstance(record, Metadata) and record.name == "tactile":
            made = made or record.metadata
        elif isinstance(record, Metadata) and record.name == COPIED:
            copied = copied or record.metadata.get("mark", "")
        elif isinstance(record, Metadata) and record.name == "counts":
            with readable(path):
                counts = {name: json.loads(value) for name, value in record.metadata.items()}
        elif isinstance(record, Attachment) and record.name == "array.toml" and data is None:
            data = record.data
        elif isinstance(record, Damage):
            damage.append(record.what)
        closed = closed or isinstance(record, Closed)
    if data is None or not made:
        raise ForeignFileError(f"{path}: not a recording of this program: an MCAP file with array.toml attached wanted")
    start, text = _checked(path, made, data)
    unknown = sum(count for number, count in numbers.items() if number not in topics)
    if unknown:
        damage.append(f"{unknown} messages are of channels that nothing describes any more")
    messages = {topics[number]: count for number, count in numbers.items() if number in topics}
    description = parse_description(text, f"{path}: array.toml")
    whole = closed and not damage
    return Recorded(path, description, made, start, counts, tuple(damage), whole, messages, topics, copied)


def read_mcap(path: Path) -> "WireSource | StoredSource":
    """Return the frames of a recording, before their tare.

    Raises:
        InputError: as `open_recording`.
    """
    return open_recording(path).source()


def _checked(path: Path, made: dict[str, str], array: bytes) -> tuple[int, str]:
    """Return the start [ns] and the array description after checking their checksums."""
    told, written = made.get(schema.SUM), made.get("version")
    if told != schema.sum_of({name: value for name, value in made.items() if name != schema.SUM}):
        raise InputError(f"{path}: damaged, or of an unknown version: the checksum of the settings is wrong")
    if written != schema.VERSION:
        raise InputError(f"{path}: a recording of version {written}; this program reads version {schema.VERSION}")
    if made.get("array_crc32") != f"{zlib.crc32(array):08x}":
        raise InputError(f"{path}: damaged: the checksum of the array description is wrong")
    with readable(path):
        return int(made["start_ns"]), array.decode()
