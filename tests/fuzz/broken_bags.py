"""Broken ROS bags: heads of huge sizes, and a good one of a pillar sensor whose bytes are to be changed."""

import struct
from pathlib import Path

from tests.fuzz.broken_texts import Broken
from tests.fuzz.changed_bytes import bytes_changed

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


def bag2(folder: Path) -> tuple[bytes, bytes]:
    """Return a ROS 2 bag of one sensor with a few messages: its data base and what is said of it."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {"papillarray_ros_v2/msg/PillarState": PILLAR, "papillarray_ros_v2/msg/SensorState": STATE}
    for kind, text in kinds.items():
        store.register(get_types_from_msg(text, kind))
    pillar, state = (store.types[kind] for kind in kinds)
    kind = "papillarray_ros_v2/msg/SensorState"
    with Writer(folder / "good", version=8) as written:
        topic = written.add_connection("/s", kind, typestore=store)
        for n in range(5):
            data = store.serialize_cdr(state(n, [pillar(n, 0, 1)] * 4), kind)
            written.write(topic, 51_000_000_000 + 1_000_000 * n, data)
    return (folder / "good" / "good.db3").read_bytes(), (folder / "good" / "metadata.yaml").read_bytes()


def bags(folder: Path, count: int) -> Broken:
    """ROS bags of both kinds; a data base lies beside the description of a good one, and the other way round."""
    yield from bag_files()
    yield from bytes_changed("b.bag", bag(folder), count)
    data, about = bag2(folder)
    (folder / "metadata.yaml").write_bytes(about)
    yield from bytes_changed("good.db3", data, count)
    (folder / "good.db3").write_bytes(data)
    for text in (b"a: " + b"[" * 5000, b"a: &a [x]\nb: [" + b"*a," * 10_000 + b"]", b"!!python/object/apply:id [x]",
                 about.replace(b": 5", b": 9223372036854775807"), about.replace(b"good.db3", b"../../etc/passwd"),
                 about.replace(b"good.db3", b"/dev/zero"), about.replace(b"sqlite3", b"mcap")):  # fmt: skip
        yield "metadata.yaml", text
    yield from bytes_changed("metadata.yaml", about, count)


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
