"""The example node publishes each frame of a recording; the modules of ROS 2 are stand-ins."""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.kits.paths import ROOT
from tests.kits.touch.presses import START, write_presses

NODE = ROOT / "examples" / "ros2" / "tactile_node.py"


class Message(SimpleNamespace):
    """A message whose parts come into being when they are used."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        setattr(self, name, Message())
        return getattr(self, name)


class Node:
    published: list[tuple[str, Any]] = []  # noqa: RUF012 - emptied by the test

    def __init__(self, name: str) -> None:
        assert name == "tactile"

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=lambda message: self.published.append((topic, message)))


def test_the_node_publishes_wrench_taxels_and_events(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(NODE.read_text(encoding="utf-8").splitlines()) <= 70
    time = SimpleNamespace(Time=lambda nanoseconds: SimpleNamespace(to_msg=lambda: nanoseconds))
    parts: dict[str, dict[str, Any]] = {
        "rclpy": {"init": lambda: None, "spin": lambda node: None, "shutdown": lambda: None},
        "rclpy.node": {"Node": Node}, "rclpy.time": vars(time), "geometry_msgs": {}, "sensor_msgs": {}, "std_msgs": {},
        "geometry_msgs.msg": {"WrenchStamped": Message}, "std_msgs.msg": {"String": Message},
        "sensor_msgs.msg": {"PointCloud2": Message, "PointField": Message},
    }  # fmt: skip
    for name, content in parts.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    Node.published.clear()
    take = write_presses(tmp_path / "a.npz", rate=100.0, seconds=1.3)
    monkeypatch.setattr(sys, "argv", [str(NODE), str(take)])
    runpy.run_path(str(NODE), run_name="__main__")
    of: dict[str, list[Any]] = {}
    for topic, message in Node.published:
        of.setdefault(topic, []).append(message)
    assert len(of["/tactile/thumb/wrench"]) == len(of["/tactile/palm/taxels"]) == 130
    assert "thumb: contact on 4 of 4 taxels" in [message.data for message in of["/tactile/events"]]
    cloud, wrench = of["/tactile/thumb/taxels"][120], of["/tactile/thumb/wrench"][120]
    assert abs(cloud.header.stamp - START - 1.2e9) < 1e3
    points = np.frombuffer(cloud.data, "<f4").reshape(cloud.height, cloud.width, len(cloud.fields))
    assert abs(points[..., 5].sum() - wrench.wrench.force.z) < 1e-5
    assert abs(wrench.wrench.force.z - 1.6) < 0.02
