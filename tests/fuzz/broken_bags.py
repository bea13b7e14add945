"""Broken ROS bags: heads of huge sizes, and a good one of a pillar sensor whose bytes are to be changed."""

import struct
from pathlib import Path

from tests.fuzz.broken_texts import Broken

PILLAR = "float32 fX\nfloat32 fY\nfloat32 fZ\n"
STATE = "int64 tus\npapillarray_ros_v2/PillarState[] pillars\n"


def bag(folder: Path) -> bytes:
    """Return a ROS 1 bag of one sensor with a few messages."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kinds = {"papillarray_ros_v2/msg/PillarState": PILLAR, "papillarray_ros_v2/msg/SensorState": STATE}
    for kind, text in kinds.items():
        store.register(get_types_from_msg(text, kind))
    pillar, state = (store.types[kind] for kind in kinds)
    kind = "papillarray_ros_v2/msg/SensorState"
    with Writer(folder / "good.bag") as written:
        topic = written.add_connection("/s", kind, typestore=store)
        for n in range(5):
            data = store.serialize_ros1(state(n, [pillar(n, 0, 1)] * 4), kind)
            written.write(topic, 51_000_000_000 + 1_000_000 * n, data)
    return (folder / "good.bag").read_bytes()


def bag_files() -> Broken:
    """ROS bags: text, a head alone, sizes of gigabytes."""
    head = b"#ROSBAG V2.0\n"
    for rest in (b"", b"\xff" * 100, struct.pack("<I", 2**31) + b"x" * 100, b"\0" * 4096,
                 struct.pack("<I", 69) + b"\x11\0\0\0chunk_count=\xff\xff\xff\x7f" + b"\0" * 5000):  # fmt: skip
        yield "b.bag", head + rest

    def field(name: bytes, value: bytes) -> bytes:
        return struct.pack("<I", len(name) + 1 + len(value)) + name + b"=" + value

    fields = field(b"op", b"\x03") + field(b"index_pos", struct.pack("<Q", 2**40)) + field(
        b"conn_count", struct.pack("<I", 2**31 - 1)) + field(b"chunk_count", struct.pack("<I", 2**31 - 1))  # fmt: skip
    record = struct.pack("<I", len(fields)) + fields
    yield "b.bag", head + record + struct.pack("<I", 4096) + b" " * 4096
    fields = field(b"op", b"\x03") + field(b"index_pos", struct.pack("<Q", 13)) + field(
        b"conn_count", struct.pack("<I", 100)) + field(b"chunk_count", struct.pack("<I", 2**31 - 1))  # fmt: skip
    yield "b.bag", head + struct.pack("<I", len(fields)) + fields + struct.pack("<I", 2**31 - 1) + b" " * 4096
