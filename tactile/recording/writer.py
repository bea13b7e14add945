"""Writer of recordings: MCAP files with wire bytes, decoded frames, and all metadata.

Topics: ``/wire`` bytes as received, ``/wire/unparsed`` bytes dropped by the decoder's queue, ``/port`` notes (plugged,
unplugged, tare), ``/frames/NAME`` frames of each finger, ``/tare`` offsets, ``/events``, ``/counts``, and ``/log`` with
ports, tares and events as text for viewers. The array description is attached as ``array.toml``; the metadata record
``tactile`` has the settings, and ``counts`` is there if the file was closed.

The data of a tenth of a second is one uncompressed chunk with its checksum; an unfinished chunk is lost with the
program. `tactile convert a.mcap b.mcap` writes the compressed form, also of an interrupted recording.
"""

import json
import platform
import threading
import time
import zlib
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from tactile.core.epoch import Epoch
from tactile.core.frame import Frame
from tactile.recording import schema
from tactile.recording.durable import DurableFile
from tactile.wire.description import Description
from tactile.wire.source import Chunk

PUSH = 0.08
"""[s] Period of the pushes; with scheduling delays below 0.1 s."""


class Recording:
    """A recording that is being written. Two threads may write; a full disk only sets ``failed``.

    ``epoch``: zero of all times; ``compressed``: larger compressed chunks, for data that can be made again;
    ``replace``: replace a recording of that name.

    Raises:
        InputError: the file cannot be made, or its name is taken.
    """

    def __init__(
        self, path: Path, description: Description, origin: dict[str, str], epoch: Epoch,
        compressed: bool = False, replace: bool = False,
    ) -> None:  # fmt: skip
        self._path, self._file = path, DurableFile(path, replace)
        self._lock, self._others = threading.Lock(), dict[str, int]()
        self._start, self._pushed, self._compressed = epoch.unix, time.monotonic(), compressed
        self._writer = Writer(
            self._file,  # type: ignore[arg-type]  # write, tell and flush are all that it uses
            chunk_size=2**20,
            compression=CompressionType.ZSTD if compressed else CompressionType.NONE,
            enable_data_crcs=True,
        )
        self._writer.start("", f"cellular-wave-touch {version('cellular-wave-touch')}")
        text = description.text.encode()
        made = {"version": schema.VERSION, "start_ns": str(self._start), "array_crc32": f"{zlib.crc32(text):08x}"}
        made |= {"title": description.title, "protocol": description.wire.name}
        made |= {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system()}
        made |= {"written": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(self._start // 10**9))}
        made |= origin
        self._writer.add_metadata("tactile", made | {schema.SUM: schema.sum_of(made)})
        self._writer.add_attachment(self._start, self._start, "array.toml", "application/toml", text)
        self._topics(description)
        self._file.settle()

    def _topics(self, description: Description) -> None:
        register = self._writer.register_channel
        wire = self._writer.register_schema(schema.WIRE_NAME, "ros2msg", schema.WIRE.encode())
        frame = self._writer.register_schema(schema.FRAME_NAME, "ros2msg", schema.FRAME.encode())
        self._wire, self._unparsed = register("/wire", "cdr", wire), register("/wire/unparsed", "cdr", wire)
        self._frames = [register(f"/frames/{array.name}", "cdr", frame) for array in description.arrays]
        notes = {
            topic: self._writer.register_schema(name, "jsonschema", text)
            for topic, (name, text) in schema.NOTES.items()
        }
        self._notes = {topic: register(topic, "json", kind) for topic, kind in notes.items()}

    @property
    def failed(self) -> str:
        """System message of a failed write; empty without a failure."""
        return self._file.failed

    @property
    def ended(self) -> str:
        """Message about a failed write and the readable part; empty without a failure."""
        if not self.failed:
            return ""
        return f"recording {self._path} ended: {self.failed}; what was written until then can be read"

    def chunk(self, chunk: Chunk, parsed: bool = True) -> None:
        """Write wire bytes, or a note about the wire."""
        if chunk.note:
            self.note("/port", chunk.t, {"note": chunk.note})
            return
        self._add(self._wire if parsed else self._unparsed, chunk.t, schema.pack_wire(chunk.data))

    def frame(self, frame: Frame, arrival: int) -> None:
        """Write a frame that arrived ``arrival`` [ns] after the epoch."""
        self._add(self._frames[frame.finger], arrival, schema.pack_frame(frame), frame.sequence % 2**32)

    def note(self, topic: str, t: int, data: dict[str, Any]) -> None:
        """Write a JSON object ``t`` [ns] after the epoch, and a log message for people."""
        self._json(topic, t, data)
        line = schema.log_line(topic, data, self._start + t)
        if line is not None:
            self._json("/log", t, line)

    def other(self, message: schema.OtherMessage) -> None:
        """Write a message of another kind."""
        if not self._file.failed:
            with self._lock:
                schema.add_other(self._writer, self._others, message)

    def _json(self, topic: str, t: int, data: dict[str, Any]) -> None:
        self._add(self._notes[topic], t, json.dumps(data, ensure_ascii=False, allow_nan=False).encode())

    def _add(self, channel: int, t: int, data: bytes, sequence: int = 0) -> None:
        if self._file.failed:
            return
        with self._lock:
            self._writer.add_message(channel, self._start + t, data, self._start + t, sequence)

    def push(self, now: bool = False) -> None:
        """Push if the last push is at least `PUSH` ago."""
        if now or time.monotonic() - self._pushed >= PUSH:
            with self._lock:
                if not self._compressed:
                    self._writer.flush()  # type: ignore[no-untyped-call]  # ends the chunk; the library left its types out
                self._file.push()
            self._pushed = time.monotonic()

    def close(self, counts: dict[str, Any]) -> None:
        """Write the counters and the index, and close."""
        with self._lock:
            self._writer.add_metadata("counts", {name: json.dumps(value) for name, value in counts.items()})
            self._writer.finish()  # type: ignore[no-untyped-call]  # the library left its types out
            self._file.close()
