"""Message schemas of a recording: ROS 2 message definitions and their CDR bytes, and JSON.

Any MCAP viewer decodes both. CDR, little endian: four bytes 00 01 00 00, then every number at a multiple of its size
counted from there; a sequence is its u32 length and its elements.

Source: OMG Common Data Representation, DDS-XTypes 1.3, section 7.4.1 (version 1, as ROS 2 writes it).
"""

import json
import struct
import zlib
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tactile.core.frame import Frame

if TYPE_CHECKING:
    from mcap.writer import Writer

VERSION = "2"
"""Version of the topics, records and messages; a reader refuses other versions."""
SUM = "crc32"
"""Entry of the metadata record ``tactile`` with `sum_of` the others."""
HEAD = b"\0\1\0\0"
WIRE_NAME, WIRE = "tactile/msg/Wire", "uint8[] data\n"
FRAME_NAME = "tactile/msg/Frame"
FRAME = """\
# One frame of one finger. values: shear_x, shear_y, normal of every taxel, row by row, before the tare, in the unit
# of the finger's quantity. t [s] since the recording began, t_device [s], NaN where the device has no clock.
# flags: status bits of the device: 1 slip detection on, 2 reference loaded, 4 contact.
float64 t
float64 t_device
int64 sequence
uint32 finger
uint32 flags
uint32 rows
uint32 cols
uint8[] valid
float64[] values
"""
FIXED = struct.Struct("<ddqIIII")
COUNT = struct.Struct("<I")


def _object(**properties: Any) -> bytes:
    """Return a JSON schema of an object; optional entries may be null."""
    return json.dumps({"type": "object", "properties": properties}).encode()


TEXT, NUMBER, WHOLE, FLAG = ({"type": kind} for kind in ("string", "number", "integer", "boolean"))
TIME = {"type": "object", "title": "time", "properties": {"sec": WHOLE, "nsec": WHOLE}}
NUMBERS = {"type": "array", "items": NUMBER}
TABLE = {"type": "object", "additionalProperties": NUMBER}
LISTS = {"type": "array"}
LOAD = {
    "type": "object",
    "properties": {"sigma": NUMBERS, "left_out": LISTS, "saturated": LISTS, "others": LISTS, "validity": TEXT},
    "additionalProperties": NUMBER,
}
LOG_NAME = "foxglove.Log"
"""Schema name of logs in viewers."""
INFO, WARNING = 2, 3
NOTES: dict[str, tuple[str, bytes]] = {
    "/port": ("tactile.Port", _object(note=TEXT)),
    "/tare": (
        "tactile.Tare",
        _object(type=TEXT, t_s=NUMBER, finger=TEXT, taken=FLAG, why=TEXT, detail=TEXT, offset=NUMBERS),
    ),
    "/events": (
        "tactile.Event",
        _object(
            type=TEXT, t_s=NUMBER, end_s=NUMBER, told_s=NUMBER, finger=TEXT, sequence=WHOLE, kind=TEXT,
            data={"type": "object"}, taxels=LISTS, confidence=NUMBER, words=TEXT, arrows=TEXT, ternary=TEXT, hand=TEXT,
            load=LOAD,
        ),
    ),
    "/counts": (
        "tactile.Status",
        _object(
            type=TEXT, t_s=NUMBER, events=WHOLE, counts=TABLE, clock=TABLE, settled={"type": "object"}, frames=WHOLE,
            rate_hz=NUMBER, latency_median_s=NUMBER, latency_p99_s=NUMBER, latency_max_s=NUMBER,
        ),
    ),
    "/log": (
        LOG_NAME, _object(timestamp=TIME, level=WHOLE, message=TEXT, name=TEXT, file=TEXT, line=WHOLE),
    ),
}  # fmt: skip
"""Topic of JSON notes -> name and schema of its messages."""


def log_line(topic: str, note: dict[str, Any], ns: int) -> dict[str, Any] | None:
    """Return a note as a log message at ``ns`` [ns] Unix time; None for a note that is only data."""
    if topic == "/port":
        name, message = "port", note["note"]
    elif topic == "/events":
        name, message = note["finger"], note["words"]
    elif topic == "/tare":
        why = f"{note['why']}: {note['detail']}" if note.get("detail") else note["why"]
        name, message = note["finger"], f"tare {'taken, ' if note['taken'] else ''}{why}"
    else:
        return None
    level = WARNING if message == "unplugged" or note.get("taken") is False else INFO
    time = {"sec": ns // 10**9, "nsec": ns % 10**9}
    return {"timestamp": time, "level": level, "message": message, "name": name, "file": "", "line": 0}


class OtherMessage(Protocol):
    """A message of another kind, such as `tactile.export.drawable.Message`."""

    @property
    def topic(self) -> str: ...  # noqa: D102 - the class says it
    @property
    def schema(self) -> str: ...  # noqa: D102
    @property
    def encoding(self) -> str: ...  # noqa: D102
    @property
    def definition(self) -> tuple[str, bytes]: ...  # noqa: D102
    @property
    def ns(self) -> int: ...  # noqa: D102
    @property
    def data(self) -> bytes: ...  # noqa: D102


def add_other(writer: "Writer", channels: dict[str, int], message: OtherMessage) -> None:
    """Write a message of another kind; its channel is made with the first message of a topic."""
    if message.topic not in channels:
        kind = writer.register_schema(message.schema, *message.definition)
        channels[message.topic] = writer.register_channel(message.topic, message.encoding, kind)
    writer.add_message(channels[message.topic], message.ns, message.data, message.ns)


def sum_of(made: dict[str, str]) -> str:
    """Return the CRC-32, in hexadecimal, of the entries of a metadata record, which MCAP does not protect."""
    return f"{zlib.crc32(json.dumps(sorted(made.items())).encode()):08x}"


def pack_wire(data: bytes) -> bytes:
    """Return the CDR bytes of a Wire message."""
    return HEAD + COUNT.pack(len(data)) + data


def unpack_wire(message: bytes) -> bytes:
    """Return the bytes in a Wire message."""
    return message[8 : 8 + COUNT.unpack_from(message, 4)[0]]


def pack_frame(frame: Frame) -> bytes:
    """Return the CDR bytes of a Frame message."""
    rows, cols = frame.valid.shape
    body = FIXED.pack(frame.t, frame.t_device, frame.sequence, frame.finger, frame.flags, rows, cols)
    body += COUNT.pack(rows * cols) + frame.valid.astype(np.uint8).tobytes()
    body += bytes(-len(body) % 4) + COUNT.pack(frame.values.size)
    body += bytes(-len(body) % 8) + frame.values.astype("<f8").tobytes()
    return HEAD + body


def unpack_frame(message: bytes) -> Frame:
    """Return the frame in a Frame message.

    Raises:
        ValueError: the stated number of taxels does not fit its length.
    """
    body = message[len(HEAD) :]
    t, t_device, sequence, finger, flags, rows, cols = FIXED.unpack_from(body)
    taxels, at = rows * cols, FIXED.size + COUNT.size
    start = at + taxels  # of the values, after their count
    start += -start % 4 + COUNT.size
    start += -start % 8
    wanted = len(HEAD) + start + taxels * 3 * 8
    if len(message) != wanted:
        raise ValueError(f"a frame of {len(message)} bytes says {rows} x {cols} taxels, which take {wanted}")
    valid = np.frombuffer(body, np.uint8, taxels, at).astype(bool).reshape(rows, cols)
    values = np.frombuffer(body, "<f8", taxels * 3, start).astype(np.float64).reshape(rows, cols, 3)
    return Frame(finger, t, sequence, values, valid, t_device, flags)
