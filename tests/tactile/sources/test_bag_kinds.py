"""ROS bags and MCAP files without definitions, folder or sound clock, compressed ones, and those of other messages."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from cnnsim.support import InputError
from tactile.core.source import provenance
from tactile.layout.layout import parse_layout
from tactile.layout.source import read_foreign
from tactile.sources import open_source
from tactile.sources.bag_process import DEFINITIONS
from tactile.sources.convert import convert

PACKAGE, N, START = "papillarray_ros_v2", 40, 1_700_000_000 * 10**9
STEP = 10**7
Stamp = Callable[[int], int]


def bag(path: Path, stamp: Stamp = lambda n: START + n * STEP, form: int = 0, **options: Any) -> Path:
    """Write a bag of one sensor of nine pillars, whose z is the number of the message."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    pillar, state = DEFINITIONS[form]
    names = [f"{PACKAGE}/msg/PillarState", f"{PACKAGE}/msg/SensorState"]
    store.register(get_types_from_msg(pillar, names[0]) | get_types_from_msg(state.format(PACKAGE), names[1]))
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]

    def made(kind: str, **known: Any) -> Any:
        fields = vars(store.types[kind])["__dataclass_fields__"]
        values = {"header": header(stamp=time(0, 0), frame_id="")} | known
        return store.types[kind](**{name: values.get(name, 0) for name in fields if not name.startswith("__")})

    writer = Writer(path, version=8, storage_plugin=options.get("plugin", StoragePlugin.SQLITE3))
    if options.get("packed"):
        writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer as out:
        topic = out.add_connection("/hub_0/sensor_0", names[1], typestore=store)
        for n in range(N):
            at = stamp(n)
            pillars = [made(names[0], fX=0.0, fY=0.5, fZ=float(n), in_contact=False) for _ in range(9)]
            flags = dict.fromkeys(("is_sd_active", "is_ref_loaded", "is_contact"), False)
            told = header(stamp=time(sec=at // 10**9, nanosec=at % 10**9), frame_id="")
            message = made(names[1], header=told, tus=n * 10**4, pillars=pillars, **flags)
            out.write(topic, START + n * STEP, store.serialize_cdr(message, names[1]))
    return path


def without_definitions(path: Path) -> None:
    with sqlite3.connect(next(path.glob("*.db3"))) as base:
        for table in ("schema", "message_definitions"):
            base.execute(f"drop table {table}")
    about = path / "metadata.yaml"
    about.write_text(about.read_text().replace("version: 8", "version: 5"))


def check(path: Path) -> None:
    frames = list(open_source(path))
    assert [frame.values[1, 1].tolist() for frame in frames] == [[0, 0.5, n] for n in range(N)]
    assert [frame.t for frame in frames] == pytest.approx([n / 100 for n in range(N)], abs=1e-9)


@pytest.mark.parametrize("form", [0, 6, len(DEFINITIONS) - 1])
def test_bags_without_definitions_are_read(tmp_path: Path, form: int) -> None:
    without_definitions(bag(tmp_path / "bag", form=form))
    check(tmp_path / "bag")


def test_a_bare_mcap_file_and_a_compressed_bag_are_read(tmp_path: Path) -> None:
    bag(tmp_path / "m", plugin=StoragePlugin.MCAP)
    check(next((tmp_path / "m").glob("*.mcap")).rename(tmp_path / "alone.mcap"))
    bag(tmp_path / "z", packed=True)
    assert not list((tmp_path / "z").glob("*.db3"))
    check(tmp_path / "z")


@pytest.mark.parametrize(
    ("stamp", "said", "start"),
    [
        (lambda n: START + n * STEP - 2 * 10**9 * (n >= 17), "step back by 1.99 s at sample 17; the times of", START),
        (lambda n: (START + n * STEP) * (n % 5 > 0 or n == 0), "missing or zero in 7 of 40 samples; the", START),
        (lambda n: START, "are all 0; the times of the bag", START),
        (lambda n: START + n * STEP + 60 * 10**9 * (n > 20), "jump by 60 s at sample 21, which the bag do not", START),
        (lambda n: n * STEP, "", START),  # time of a simulation
        (lambda n: START + 3 * 10**9 + n * STEP, "", START + 3 * 10**9),
    ],
)  # fmt: skip
def test_header_stamps_with_a_fault_are_replaced(tmp_path: Path, stamp: Stamp, said: str, start: int) -> None:
    source = open_source(bag(tmp_path / "bag", stamp))
    assert said in " ".join(getattr(source, "notes", ()))
    assert bool(said) == bool(getattr(source, "notes", ()))
    assert provenance(source).start_ns == start
    check(tmp_path / "bag")
    convert(tmp_path / "bag", tmp_path / "a.csv")
    check(tmp_path / "a.csv")


LAYOUT = """
[layout]
time = "log_time"
time_unit = "ns"
topic = "{topic}"
[[finger]]
name = "f"
rows = 1
cols = 2
pitch_mm = 4
depth_mm = 0
quantity = "force"
columns = "{columns}"
axes = ["z"]
"""


def test_a_topic_and_a_field_path_of_other_messages(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    kind, empty = "std_msgs/msg/Float64MultiArray", store.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    with Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.MCAP) as out:
        topics = [out.add_connection(name, kind, typestore=store) for name in ("/skin", "/other")]
        for n in range(6):
            message = store.types[kind](layout=empty, data=np.array([n, 2.0 * n]))
            out.write(topics[n % 5 == 4], START + n * STEP, store.serialize_cdr(message, kind))
    with (tmp_path / "j.mcap").open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        channel = writer.register_channel("/skin", "json", 0)
        for n in range(5):
            body = {"taxels": [{"f": n, "id": 1}, {"f": 2 * n, "id": 2}], "note": "x"}
            writer.add_message(channel, START + n * STEP, json.dumps(body).encode(), START)
        writer.finish()  # type: ignore[no-untyped-call]  # the library left its types out
    for name, columns in (("bag", "data"), ("j.mcap", "taxels.f")):
        with pytest.raises(InputError, match=r"it has log_time, .*`tactile layout"):
            open_source(tmp_path / name)
        source = open_source(tmp_path / name, parse_layout(LAYOUT.format(topic="/skin", columns=columns), "l"))
        assert [frame.values[0, :, 2].tolist() for frame in source][:4] == [[n, 2 * n] for n in range(4)]
        with pytest.raises(InputError, match=r"topic '/no' wanted; it has /skin"):
            read_foreign(tmp_path / name, parse_layout(LAYOUT.format(topic="/no", columns=columns), "l"))
