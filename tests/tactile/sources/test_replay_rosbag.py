"""ROS bags of PapillArray sensors as sources of frames."""

from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from cnnsim.support import InputError
from tactile.sources import open_source

PILLAR = "float32 fX\nfloat32 fY\nfloat32 fZ\n"
STATE = "int64 tus\nsensor_interfaces/PillarState[] pillars\n"


def test_ros_bags_of_pillars(tmp_path: Path) -> None:
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
    with pytest.raises(InputError, match="cannot be read as a ROS bag"):
        open_source(tmp_path / "empty")
