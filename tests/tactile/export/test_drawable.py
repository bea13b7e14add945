"""Messages for viewers and ROS 2 bags: standard types, right numbers, read back by the libraries of others."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import tactile
from tactile.export import view
from tactile.export.drawable import topic_names
from tactile.wire.packets import emulated_description, packets
from tests.kits.serial import call, device, grip, lines, write_array
from tests.kits.touch.presses import START, write_presses


@pytest.fixture(scope="module")
def take(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_presses(tmp_path_factory.mktemp("drawable") / "a.npz", rate=100.0, seconds=1.7)


def points(cloud: Any) -> dict[str, np.ndarray]:
    data = np.frombuffer(bytes(cloud.data), "<f4").reshape(cloud.height, cloud.width, -1)
    assert [(one.offset, one.datatype) for one in cloud.fields] == [(4 * n, 7) for n in range(len(cloud.fields))]
    assert cloud.row_step == cloud.width * cloud.point_step == 4 * data[0].size
    return {one.name: data[..., n] for n, one in enumerate(cloud.fields)}


def test_a_ros_2_bag_has_standard_messages_that_rosbags_reads(take: Path, tmp_path: Path) -> None:
    done = call("convert", take, "--ros2", tmp_path / "bag")
    assert done.exit_code == 0, done.output
    with tactile.stream(take) as stream:
        frames: dict[str, list[tactile.StreamFrame]] = {"thumb": [], "palm": []}
        for frame in stream:
            frames[frame.finger].append(frame)
    standard = {"sensor_msgs", "geometry_msgs", "visualization_msgs", "rcl_interfaces"}
    found: dict[str, list[Any]] = {}
    with AnyReader([tmp_path / "bag"]) as bag:
        assert {one.msgtype.split("/")[0] for one in bag.connections} == standard
        for connection, ns, raw in bag.messages():
            message = bag.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((ns, message))
    clouds, wrenches = found["/tactile/thumb/taxels"], found["/tactile/thumb/wrench"]
    assert len(clouds) == len(wrenches) == len(frames["thumb"])
    for (ns, cloud), (_, wrench), frame in list(zip(clouds, wrenches, frames["thumb"], strict=True))[::10]:
        stamp = cloud.header.stamp.sec * 10**9 + cloud.header.stamp.nanosec
        assert ns == stamp == START + round(frame.t * 1e9)
        assert cloud.header.frame_id == wrench.header.frame_id == "thumb"
        fields = points(cloud)
        assert np.allclose(fields["x"], [[-0.002, 0.002]] * 2)
        for n, name in enumerate(("shear_x", "shear_y", "normal")):
            wanted = np.where(frame.valid, frame.values[..., n], np.nan)
            assert np.allclose(fields[name], wanted, atol=1e-6, equal_nan=True)
        force = wrench.wrench.force
        assert np.allclose([force.x, force.y, force.z], np.nan_to_num([frame.load.Q, frame.load.R, frame.load.F]))
    pictures = found["/tactile/palm/normal"]
    assert 40 <= len(pictures) <= 52  # at most 30 a second
    assert {(one.encoding, one.height, one.width, len(one.data)) for _, one in pictures} == {("32FC1", 1, 3, 12)}
    assert {(len(one.points), one.type) for _, one in found["/tactile/palm/shear"]} == {(6, 5)}
    logged = [message.msg for _, message in found["/tactile/log"]]
    assert logged.count("contact on 4 of 4 taxels") == logged.count("contact on 3 of 3 taxels") == 1
    texts = [one.text for _, one in found["/tactile/thumb/events"]]
    assert any("contact" in text for text in texts)
    assert texts[-1].strip() == ""
    again = call("convert", take, "--ros2", tmp_path / "bag")
    assert again.exit_code == 2
    assert "there is something of that name" in again.stderr


def test_topics_are_names_that_ros_allows() -> None:
    assert topic_names(["hub_0-sensor_1", "3", "a-b", "a_b"]) == {
        "hub_0-sensor_1": "hub_0_sensor_1", "3": "finger_3", "a-b": "a_b", "a_b": "a_b_3",
    }  # fmt: skip


def drawn(path: Path) -> dict[str, list[tuple[Any, Any]]]:
    """Return the messages of an MCAP file by topic, each with its schema, decoded by its own definition."""
    found: dict[str, list[tuple[Any, Any]]] = {}
    stores: dict[str, Any] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            if channel.message_encoding == "json":
                data = json.loads(message.data)
            else:
                if schema.name not in stores:
                    stores[schema.name] = get_typestore(Stores.EMPTY)
                    stores[schema.name].register(get_types_from_msg(schema.data.decode(), schema.name))
                data = stores[schema.name].deserialize_cdr(message.data, schema.name)
            found.setdefault(channel.topic, []).append((schema, data))
    return found


def check_drawn(found: dict[str, list[tuple[Any, Any]]], finger: str) -> None:
    names = {topic: one[0][0].name for topic, one in found.items()}
    assert names[f"/tactile/{finger}/taxels"] == "sensor_msgs/msg/PointCloud2"
    assert names[f"/tactile/{finger}/wrench"] == "geometry_msgs/msg/WrenchStamped"
    assert names[f"/tactile/{finger}/normal"] == "sensor_msgs/msg/Image"
    assert names[f"/tactile/{finger}/shear"] == names[f"/tactile/{finger}/events"] == "foxglove.SceneUpdate"
    assert names["/tactile/log"] == "foxglove.Log"
    for schema, update in found[f"/tactile/{finger}/shear"]:
        (entity,) = update["entities"]
        items = json.loads(schema.data)["properties"]["entities"]["items"]["properties"]
        assert set(entity) == set(items)
        assert entity["frame_id"] == finger
        for arrow in entity["arrows"]:
            assert set(arrow) == set(items["arrows"]["items"]["properties"])
    assert any(update["entities"][0]["arrows"] for _, update in found[f"/tactile/{finger}/shear"])
    assert any("contact on" in line["message"] for _, line in found["/tactile/log"])
    texts = [entity["texts"] for _, update in found[f"/tactile/{finger}/events"] for entity in update["entities"]]
    assert any("contact" in text["text"] for part in texts for text in part)


def test_mcap_files_get_what_viewers_draw_beside_the_frames(take: Path, tmp_path: Path) -> None:
    for source, target in ((take, "frames.mcap"), (tmp_path / "frames.mcap", "copy.mcap")):
        if target == "copy.mcap":
            call("convert", take, source, "--replace")
        done = call("convert", source, tmp_path / target, "--drawable")
        assert done.exit_code == 0, done.output
        found = drawn(tmp_path / target)
        check_drawn(found, "thumb")
        assert len(found["/frames/thumb"]) == len(found["/tactile/thumb/taxels"]) == 170
    refused = call("convert", take, tmp_path / "x.csv", "--drawable")
    assert refused.exit_code == 2
    assert "fit into no .csv file; .mcap wanted" in refused.stderr


def test_live_records_and_shows_what_viewers_draw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[tuple[str, int]] = []

    class Channel:
        def __init__(self, topic: str, schema: Any, message_encoding: str) -> None:
            assert schema.data and message_encoding in ("cdr", "json")
            self.topic = topic

        def log(self, data: bytes, log_time: int) -> None:
            sent.append((self.topic, log_time))

    server = SimpleNamespace(port=8765, stop=lambda: None)
    library = SimpleNamespace(
        start_server=lambda **words: server, Schema=lambda **words: SimpleNamespace(**words), Channel=Channel
    )
    monkeypatch.setattr(view, "need", lambda module, what, extra: library)
    scene = grip(0.4)
    description = emulated_description("native", scene)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    words = ["--record", mcap, "--drawable", "--view", "foxglove", "--json", "--tare", "off", "--once"]
    with device(list(packets(description, scene))) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, *words, "--seconds", "20")
    assert live.exit_code == 0, live.output
    assert "open connection ws://127.0.0.1:8765" in live.stderr
    found = drawn(mcap)
    check_drawn(found, "left")
    assert len(found["/tactile/left/taxels"]) == len(found["/frames/left"]) == 80
    assert sum(topic == "/tactile/left/taxels" for topic, _ in sent) == 80
    replayed = call("replay", mcap, "--json")
    assert lines(replayed.stdout, "event") == lines(live.stdout, "event")
    alone = call("live", "-p", "x", "-a", array, "--drawable")
    assert alone.exit_code == 2
    assert "part of --record FILE" in alone.stderr
