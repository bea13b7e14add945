"""ROS 1 and ROS 2 bags of PapillArray sensors."""

import json
from pathlib import Path

import pytest
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from cnnsim.support import InputError
from tactile.core.frame import FLAGS
from tactile.core.source import provenance
from tactile.sources import open_source
from tactile.sources.convert import convert
from tests.kits.serial import call

PILLAR = "float32 fX\nfloat32 fY\nfloat32 fZ\n"
STAMPED = (
    "std_msgs/Header header\nint64 tus\nbool is_sd_active\nbool is_ref_loaded\nbool is_contact\n"
    "papillarray_ros_v2/PillarState[] pillars\n"
)
STATE = "int64 tus\nsensor_interfaces/PillarState[] pillars\n"


def test_ros_1_headers_and_flags_are_kept(tmp_path: Path) -> None:
    """Sequence number and time come from the message header, also for late messages in wrong order."""
    store = get_typestore(Stores.ROS1_NOETIC)
    kinds = {"papillarray_ros_v2/msg/PillarState": PILLAR, "papillarray_ros_v2/msg/SensorState": STAMPED}
    for kind, text in kinds.items():
        store.register(get_types_from_msg(text, kind))
    pillar, state = (store.types[kind] for kind in kinds)
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    messages = [(7, 100, 1, True, False, False), (9, 104, 2, True, True, False), (3, 102, 3, False, True, True)]
    with BagWriter(tmp_path / "a.bag") as bag:
        topics = [bag.add_connection(f"/s{n}", "papillarray_ros_v2/msg/SensorState", typestore=store) for n in (0, 1)]
        for n, (seq, ms, tus, *flags) in enumerate(messages):
            stamp = header(seq, time(50, 1_000_000 * ms), "")
            data = store.serialize_ros1(
                state(stamp, tus, *flags, [pillar(n, 0, 1)]), "papillarray_ros_v2/msg/SensorState"
            )
            bag.write(topics[n // 2], 51_000_000_000 + 1_000_000 * n, data)
    source = open_source(tmp_path / "a.bag")
    wanted = [(0, 7, 0.0, 1e-6, 1), (1, 3, 0.002, 3e-6, 6), (0, 9, 0.004, 2e-6, 3)]
    found = [(one.finger, one.sequence, round(one.t, 9), one.t_device, one.flags) for one in source]
    assert found == wanted
    assert FLAGS == {"slip_detection": 1, "reference_loaded": 2, "contact": 4}
    assert provenance(source).start_ns == 50_100_000_000
    assert not getattr(source, "others", None)
    result = call("run", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    assert [(one["recording"], one.get("frames")) for one in json.loads(result.stdout)["recordings"]] == [("a.bag", 3)]
    for target in ("b.npz", "b.parquet", "b.csv", "b.mcap"):
        convert(tmp_path / ("a.bag" if target == "b.npz" else "b.npz"), tmp_path / target)
        again = [
            (one.finger, one.sequence, round(one.t, 9), one.t_device, one.flags)
            for one in open_source(tmp_path / target)
        ]
        assert again == wanted


def test_ros_2_bags(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {"sensor_interfaces/msg/PillarState": PILLAR, "sensor_interfaces/msg/SensorState": STATE}
    for kind, text in kinds.items():
        store.register(get_types_from_msg(text, kind))
    pillar, state = (store.types[kind] for kind in kinds)
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topics = [
            bag.add_connection(f"/hub_0/sensor_{n}", "sensor_interfaces/msg/SensorState", typestore=store)
            for n in (0, 1)
        ]
        for n in range(6):
            values = [pillar(n + 0.5, -n, k) for k in range(9)]
            data = store.serialize_cdr(state(1000 * n, values), "sensor_interfaces/msg/SensorState")
            bag.write(topics[n % 2], 5_000_000_000 + 1_000_000 * n, data)
    source = open_source(tmp_path / "bag")
    frames = list(source)
    assert [array.name for array in source.arrays] == ["hub_0-sensor_0", "hub_0-sensor_1"]
    assert [(frame.finger, frame.sequence) for frame in frames] == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]
    assert [frame.t for frame in frames] == pytest.approx([0.001 * n for n in range(6)], abs=1e-12)
    assert frames[3].values[2, 1].tolist() == [3.5, -3.0, 7.0]
    assert frames[3].t_device == pytest.approx(0.003, abs=1e-12)
    assert source.frames == 6
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "metadata.yaml").touch()
    with pytest.raises(InputError, match="cannot be read as a ROS bag"):
        open_source(tmp_path / "empty")
