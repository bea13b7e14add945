"""ROS bag reader process: isolates the library, which generates code from a bag's definitions and trusts its sizes.

Its output is a line of JSON with the contents of the bag, then the frames: `FRAME` with finger, stamp of the message
header [ns] (`NONE` without one), time of recording [ns], device time [us], sequence number, device flags and number of
pillars, then the forces. The sequence number is that of a ROS 1 header, else a count. With a topic as second argument
the output is an NPZ file with every number and text of its messages (`tactile.layout.message_table`).
"""

import io
import json
import math
import resource
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FRAME = struct.Struct("<IqqdqBI")
FLAGS = ("is_sd_active", "is_ref_loaded", "is_contact")
"""Fields of a message that are the bits of `tactile.core.frame.FLAGS`, in order."""
KIND = "SensorState"
NONE = -(2**63)
"""Stamp of a message without a header."""
MEMORY, PACKED = 2**30, 2**33
"""Memory limit of the process in bytes; and of the files to which a compressed bag is unpacked."""
CUT = 300
"""Longest message in characters."""
FORCES = "float32 fX\nfloat32 fY\nfloat32 fZ\n"
STATES = "{}/PillarState[] pillars\n"
GLOBAL = "".join(f"float32 {name}\n" for name in ("gfX", "gfY", "gfZ", "gtX", "gtY", "gtZ", "friction_est"))
GLOBAL += "float32 target_grip_force\n" + "".join(f"bool {name}\n" for name in FLAGS)
MOVED = "int32 id\nfloat32 dX\nfloat32 dY\nfloat32 dZ\n" + FORCES + "bool in_contact\nint32 slip_state\n"
HEADER, CLOCK = "std_msgs/Header header\n", "int64 tus\n"
DEFINITIONS = tuple(
    (pillar, head + CLOCK + STATES + rest)
    for pillar in (HEADER + MOVED, MOVED, FORCES)
    for head in (HEADER, "")
    for rest in (GLOBAL, "".join(f"bool {name}\n" for name in FLAGS), "")
)
"""Definitions of PillarState and SensorState for bags without any: those of the maker's drivers, and shorter ones."""


def main(path: Path, topic: str | None = None) -> None:
    """Write the contents of a bag, or the table of a topic."""
    packed = path.is_dir() and any(path.glob("*.zstd"))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    limit = PACKED if packed else 0  # else it writes nothing
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        with _opened(path) as bag:
            if topic is None:
                _write_frames(bag)
            else:
                _write_table(bag, topic)
    except BrokenPipeError:
        return
    except Exception as error:  # any exception of the library on a broken bag becomes one message
        said = " ".join(str(error).split()) or type(error).__name__
        sys.stderr.write(said[:CUT])
        sys.exit(2)


def _opened(path: Path) -> Any:
    """Return a reader of a bag; messages without a definition have the first of `DEFINITIONS` that fits them."""
    from rosbags.highlevel import AnyReader  # within the limits
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)

    def register(package: str, form: tuple[str, str]) -> str:
        kind, (pillar, state) = f"{package}/msg/{KIND}", form
        types.register(get_types_from_msg(pillar, f"{package}/msg/PillarState"))
        types.register(get_types_from_msg(state.format(package), kind))
        return kind

    with AnyReader([path], default_typestore=types) as bag:
        known = bag.typestore.fielddefs
        bare = [one for one in bag.connections if one.msgtype.endswith(f"/{KIND}") and one.msgtype not in known]
        first = [raw for one in bare[:1] for _, _, raw in _first(bag.messages([one]))]
    for raw in first:
        for number, form in enumerate(DEFINITIONS):
            kind = register(f"form{number}", form)
            try:
                again = bytes(types.serialize_cdr(types.deserialize_cdr(raw, kind), kind))
            except Exception:  # the library raises anything on bytes of another definition
                continue
            if again == bytes(raw)[: len(again)] and len(raw) - len(again) < 4:
                for package in {one.msgtype.split("/", maxsplit=1)[0] for one in bare}:
                    register(package, form)
                break
        else:
            kind = bare[0].msgtype
            raise ValueError(
                f"no definition of {kind} in it, and its messages of {len(raw)} bytes are of no known form"
            )
    return AnyReader([path], default_typestore=types)


def _first(messages: Iterator[Any]) -> list[Any]:
    return [one for _, one in zip(range(1), messages, strict=False)]


def _write_frames(bag: Any) -> None:
    out = sys.stdout.buffer
    found = [c for c in bag.connections if c.msgtype.endswith(f"/{KIND}") and c.msgcount]
    topics = sorted({connection.topic for connection in found})
    first = {topic: next(_messages(bag, [topic])) for topic in topics}
    fields = {
        topic: sorted({*vars(message)} - {"tus", "pillars", "header", *FLAGS})
        for topic, (_, _, message) in first.items()
    }
    others = sorted(f"topic {one}" for one in {c.topic for c in bag.connections} - set(topics))
    others += [f"{topic} {name}" for topic in topics for name in fields[topic] if not name.startswith("_")]
    about = {
        "kinds": sorted({c.msgtype for c in bag.connections}), "topics": topics, "others": others,
        "pillars": [len(message.pillars) for _, _, message in first.values()], "frames": sum(c.msgcount for c in found),
    }  # fmt: skip
    out.write(json.dumps(about).encode() + b"\n")
    out.flush()
    counts = dict.fromkeys(topics, 0)
    for topic, stamp, message in _messages(bag, topics):
        header = getattr(message, "header", None)
        sequence = getattr(header, "seq", counts[topic])
        counts[topic] += 1
        flags = sum(bool(getattr(message, name, False)) << bit for bit, name in enumerate(FLAGS))
        forces = [float(part) for p in message.pillars for part in (p.fX, p.fY, p.fZ)]
        said = NONE if header is None else header.stamp.sec * 10**9 + header.stamp.nanosec
        tus = float(getattr(message, "tus", math.nan))
        out.write(
            FRAME.pack(topics.index(topic), said, stamp, tus, int(sequence), flags, len(message.pillars))
            + struct.pack(f"<{len(forces)}d", *forces)
        )
    out.flush()


def _write_table(bag: Any, topic: str) -> None:
    from tactile.layout.message_table import pick_topic, stacked  # within the limits

    kinds = {one.topic: f"{one.msgtype}, {one.msgcount} messages" for one in bag.connections if one.msgcount}
    name = pick_topic(topic, kinds)
    rows = ({"log_time": stamp, **_plain(message)} for _, stamp, message in _messages(bag, [name]))
    whole = io.BytesIO()
    stacked(rows, name, kinds, whole)
    sys.stdout.buffer.write(whole.getvalue())
    sys.stdout.flush()


def _plain(message: Any) -> Any:
    """Return a message as nested dictionaries; a time as ns."""
    if hasattr(message, "sec") and hasattr(message, "nanosec"):
        return message.sec * 10**9 + message.nanosec
    if hasattr(message, "__msgtype__"):
        return {name: _plain(one) for name, one in vars(message).items() if not name.startswith("_")}
    return [_plain(one) for one in message] if isinstance(message, list) else message


def _messages(bag: Any, topics: list[str]) -> Iterator[tuple[str, int, Any]]:
    wanted = [connection for connection in bag.connections if connection.topic in topics]
    for connection, stamp, raw in bag.messages(wanted):
        yield connection.topic, stamp, bag.deserialize(raw, connection.msgtype)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
