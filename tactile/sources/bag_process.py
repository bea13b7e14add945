"""ROS bag reader process: isolates the library, which generates code from a bag's definitions and trusts its sizes.

Its output is a line of JSON with the contents of the bag, then the frames: `FRAME` with finger, time [ns], device time
[us], sequence number, device flags and number of pillars, then the forces. Time and sequence number are those of the
message header; without a header they are the time of recording and a count.
"""

import json
import math
import resource
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FRAME = struct.Struct("<IqdqBI")
FLAGS = ("is_sd_active", "is_ref_loaded", "is_contact")
"""Fields of a message that are the bits of `tactile.core.frame.FLAGS`, in order."""
KIND = "SensorState"
MEMORY = 2**30
"""Memory limit of the process in bytes."""
CUT = 300
"""Longest message in characters."""


def main(path: Path) -> None:
    """Write the contents of a bag."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # it writes nothing
    try:
        _tell(path)
    except BrokenPipeError:
        return
    except Exception as error:  # any exception of the library on a broken bag becomes one message
        said = " ".join(str(error).split()) or type(error).__name__
        sys.stderr.write(said[:CUT])
        sys.exit(2)


def _tell(path: Path) -> None:
    from rosbags.highlevel import AnyReader  # within the limits
    from rosbags.typesys import Stores, get_typestore

    out = sys.stdout.buffer
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
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
            "pillars": [len(message.pillars) for _, _, message in first.values()],
            "starts": [_stamp(message, stamp) for _, stamp, message in first.values()],
            "frames": sum(c.msgcount for c in found),
        }  # fmt: skip
        out.write(json.dumps(about).encode() + b"\n")
        out.flush()
        counts = dict.fromkeys(topics, 0)
        for topic, stamp, message in _messages(bag, topics):
            sequence = getattr(getattr(message, "header", None), "seq", counts[topic])
            counts[topic] += 1
            flags = sum(bool(getattr(message, name, False)) << bit for bit, name in enumerate(FLAGS))
            forces = [float(part) for p in message.pillars for part in (p.fX, p.fY, p.fZ)]
            tus = float(getattr(message, "tus", math.nan))
            out.write(
                FRAME.pack(topics.index(topic), _stamp(message, stamp), tus, int(sequence), flags, len(message.pillars))
            )
            out.write(struct.pack(f"<{len(forces)}d", *forces))
    out.flush()


def _stamp(message: Any, got: int) -> int:
    """Return the time of a message [ns]: that of its header, or the time ``got`` of recording."""
    said = getattr(getattr(message, "header", None), "stamp", None)
    return got if said is None else (said.sec * 10**9 + said.nanosec) or got


def _messages(bag: Any, topics: list[str]) -> Iterator[tuple[str, int, Any]]:
    wanted = [connection for connection in bag.connections if connection.topic in topics]
    for connection, stamp, raw in bag.messages(wanted):
        yield connection.topic, stamp, bag.deserialize(raw, connection.msgtype)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
