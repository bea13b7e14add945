"""Messages that viewers draw: point clouds, wrenches, images of the normal, arrows of the shear, events.

ROS 2 messages (CDR) of ``std_msgs``, ``geometry_msgs``, ``sensor_msgs``, ``visualization_msgs`` and ``rcl_interfaces``,
which RViz, Foxglove, Lichtblick and Rerun read; for MCAP arrows and events are ``foxglove.SceneUpdate`` and
``foxglove.Log`` (JSON). The frame_id is the finger's name; lengths are in metres in the finger's frame.

Topics: ``/tactile/NAME/taxels`` sensor_msgs/PointCloud2 with x, y, z, shear_x, shear_y and normal of every taxel;
``/tactile/NAME/wrench`` geometry_msgs/WrenchStamped with Q, R, F and the torque about z; at most 30 times a second
``/tactile/NAME/normal`` sensor_msgs/Image (32FC1) of the normal component and ``/tactile/NAME/shear`` with an arrow or
line a taxel; ``/tactile/NAME/events``, the text of the lasting events; ``/tactile/log``, a line for each event.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

import numpy as np
from rosbags.typesys import Stores, get_typestore

from cnnsim.support import Floats
from tactile.core.frame import NORMAL, TaxelArray
from tactile.events.event import Event
from tactile.export.scene import LOG, SCENE, SCENE_NAME, arrows_scene, log_message, text_scene
from tactile.pipeline import FrameReport
from tactile.recording.schema import LOG_NAME

PERIOD = 1 / 30
"""[s] Least time between two pictures of a finger."""
FLOAT32 = 7
LINE_LIST, TEXT = 5, 9
"""Numbers of PointField and Marker."""
INFO = 20
FIELDS = ("x", "y", "z", "shear_x", "shear_y", "normal")


@dataclass(frozen=True)
class Message:
    """One message: ``topic``, name of its ``schema``, Unix time [ns], and bytes: ``encoding`` CDR or JSON."""

    topic: str
    schema: str
    ns: int
    data: bytes
    encoding: Literal["cdr", "json"] = "cdr"

    @property
    def definition(self) -> tuple[str, bytes]:
        """Encoding and text of the schema."""
        if self.encoding == "json":
            return "jsonschema", (SCENE if self.schema == SCENE_NAME else LOG).encode()
        return "ros2msg", typestore().generate_msgdef(self.schema, ros_version=2)[0].encode()


@cache
def typestore() -> Any:
    """Return the message types of ROS 2 Humble."""
    return get_typestore(Stores.ROS2_HUMBLE)


class Drawable:
    """Converts the reports of a run to messages; ``ros``: standard ROS 2 messages only.

    ``start_ns``: Unix time [ns] at which t is 0.
    """

    def __init__(self, arrays: tuple[TaxelArray, ...], start_ns: int, *, ros: bool) -> None:
        self._start, self._ros = start_ns, ros
        self._fingers = {array.name: _Finger(array) for array in arrays}
        self._topics = topic_names([array.name for array in arrays])
        self._last: dict[str, float] = {}
        self._lasting: dict[tuple[Any, ...], Event] = {}

    def __call__(self, report: FrameReport) -> Iterator[Message]:
        """Yield the messages of the next report."""
        name, frame = report.array.name, report.frame
        topic = self._topics[name]
        ns = self._start + round(frame.t * 1e9)
        finger, header = self._fingers[name], _header(ns, name)
        values = np.where(frame.valid[..., None], frame.values, np.nan).astype(np.float32)
        yield self._cdr(f"{topic}/taxels", ns, finger.cloud(header, values))
        load = report.load
        force = [part if part == part else 0.0 for part in (load.Q, load.R, load.F, load.torque)]
        wrench = _make(
            "geometry_msgs/Wrench", force=_vector(force[0], force[1], force[2]), torque=_vector(0.0, 0.0, force[3])
        )
        yield self._cdr(f"{topic}/wrench", ns, _make("geometry_msgs/WrenchStamped", header=header, wrench=wrench))
        if frame.t - self._last.get(name, -np.inf) >= PERIOD * (1 - 1e-9):
            self._last[name] = frame.t
            yield self._cdr(f"{topic}/normal", ns, _image(header, values[..., NORMAL]))
            lines = finger.lines(values, report)
            if self._ros:
                yield self._cdr(f"{topic}/shear", ns, _lines_marker(header, lines, report.array.pitch))
            else:
                data = arrows_scene(name, ns, lines, report.array.pitch)
                yield Message(f"/tactile/{topic}/shear", SCENE_NAME, ns, data, "json")
        if report.events or report.ended:
            yield from self._events(report, ns)

    def _events(self, report: FrameReport, ns: int) -> Iterator[Message]:
        for event in report.events:
            self._lasting[event.key] = event
            if self._ros:
                log = _make("rcl_interfaces/Log", stamp=_time(ns), level=INFO, name=event.finger, msg=event.words,
                            file="", function="", line=0)  # fmt: skip
                yield self._cdr("log", ns, log)
            else:
                yield Message("/tactile/log", LOG_NAME, ns, log_message(event, ns), "json")
        for event in report.ended:
            self._lasting.pop(event.key, None)
        for name in {event.finger for event in (*report.events, *report.ended)} & set(self._fingers):
            array = self._fingers[name].array
            place = (array.origin[0], array.origin[1] - (array.rows / 2 + 1) * array.pitch)
            text = "\n".join(event.words for event in self._lasting.values() if event.finger == name)
            if self._ros:
                yield self._cdr(
                    f"{self._topics[name]}/events", ns, _text_marker(_header(ns, name), text, place, array.pitch)
                )
            else:
                data = text_scene(name, ns, text, (*place, array.pitch))
                yield Message(f"/tactile/{self._topics[name]}/events", SCENE_NAME, ns, data, "json")

    @staticmethod
    def _cdr(topic: str, ns: int, message: Any) -> Message:
        kind = message.__msgtype__
        return Message(f"/tactile/{topic}", kind, ns, bytes(typestore().serialize_cdr(message, kind)))


def topic_names(fingers: Iterable[str]) -> dict[str, str]:
    """Return the part of a ROS 2 topic for each finger: letters, digits and _, no digit first, no name twice."""
    found: dict[str, str] = {}
    for finger in fingers:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", finger)
        plain = f"finger_{plain}" if plain[0].isdigit() else plain
        found[finger] = plain if plain not in found.values() else f"{plain}_{len(found)}"
    return found


@dataclass
class _Finger:
    """Parts of the messages of a finger that do not change, and the largest shear so far."""

    array: TaxelArray
    largest: float = 0.0
    places: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.places = np.zeros((*self.array.shape, 3))
        self.places[..., :2] = self.array.positions()
        self._fields = [
            _make("sensor_msgs/PointField", name=name, offset=4 * n, datatype=FLOAT32, count=1)
            for n, name in enumerate(FIELDS)
        ]

    def cloud(self, header: Any, values: Any) -> Any:
        points = np.concatenate((self.places.astype("<f4"), values.astype("<f4")), -1)
        rows, cols = self.array.shape
        return _make(
            "sensor_msgs/PointCloud2", header=header, height=rows, width=cols, fields=self._fields, is_bigendian=False,
            point_step=4 * len(FIELDS), row_step=4 * len(FIELDS) * cols, is_dense=bool(np.isfinite(values).all()),
            data=np.frombuffer(points.tobytes(), np.uint8),
        )  # fmt: skip

    def lines(self, values: Any, report: FrameReport) -> Floats:
        """Return (n, 2, 3): begin and end of a line [m] along the shear of every taxel; the largest is a pitch long."""
        shear = np.nan_to_num(values[..., :NORMAL].astype(float))
        least = 0.0 if report.levels is None else float(report.levels.on[..., :NORMAL].max())
        self.largest = max(self.largest, float(np.hypot(*np.moveaxis(shear, -1, 0)).max()), least)
        ends = self.places.copy()
        if self.largest > 0:
            ends[..., :2] += self.array.pitch * shear / self.largest
        return np.stack((self.places, ends), -2).reshape(-1, 2, 3)


def _make(kind: str, /, **parts: Any) -> Any:
    package, name = kind.split("/")
    return typestore().types[f"{package}/msg/{name}"](**parts)


def _time(ns: int) -> Any:
    return _make("builtin_interfaces/Time", sec=ns // 10**9, nanosec=ns % 10**9)


def _header(ns: int, frame: str) -> Any:
    return _make("std_msgs/Header", stamp=_time(ns), frame_id=frame)


def _vector(x: float, y: float, z: float) -> Any:
    return _make("geometry_msgs/Vector3", x=float(x), y=float(y), z=float(z))


def _point(x: float, y: float, z: float) -> Any:
    return _make("geometry_msgs/Point", x=float(x), y=float(y), z=float(z))


def _image(header: Any, plane: Any) -> Any:
    rows, cols = plane.shape
    data = np.frombuffer(plane.astype("<f4").tobytes(), np.uint8)
    return _make("sensor_msgs/Image", header=header, height=rows, width=cols, encoding="32FC1", is_bigendian=0,
                 step=4 * cols, data=data)  # fmt: skip


def _lines_marker(header: Any, lines: Floats, pitch: float) -> Any:
    points = [_point(*point) for point in lines.reshape(-1, 3).tolist()]
    return _marker(header, LINE_LIST, "shear", points=points, scale=_vector(pitch / 10, 0, 0))


def _text_marker(header: Any, text: str, place: tuple[float, float], size: float) -> Any:
    at = _make("geometry_msgs/Pose", position=_point(*place, 0.0), orientation=_upright())
    return _marker(header, TEXT, "events", text=text or " ", pose=at, scale=_vector(0, 0, size))


def _upright() -> Any:
    return _make("geometry_msgs/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)


def _marker(header: Any, kind: int, namespace: str, **parts: Any) -> Any:
    pose = _make("geometry_msgs/Pose", position=_point(0, 0, 0), orientation=_upright())
    colour = _make("std_msgs/ColorRGBA", r=0.1, g=0.4, b=1.0, a=1.0)
    frame = {"mesh_file": _make("visualization_msgs/MeshFile", filename="", data=np.zeros(0, np.uint8)),
             "texture": _make("sensor_msgs/CompressedImage", header=header, format="", data=np.zeros(0, np.uint8)),
             "uv_coordinates": [], "texture_resource": ""}  # fmt: skip
    known = {"pose": pose, "points": [], "text": "", **frame} | parts
    return _make("visualization_msgs/Marker", header=header, ns=namespace, id=0, type=kind, action=0, color=colour,
                 lifetime=_make("builtin_interfaces/Duration", sec=0, nanosec=0), frame_locked=False, colors=[],
                 mesh_resource="", mesh_use_embedded_materials=False, **known)  # fmt: skip
