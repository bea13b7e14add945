"""JSON messages foxglove.SceneUpdate and foxglove.Log, with the parts of their published schemas that are used.

Source: foxglove-sdk, schemas/jsonschema/SceneUpdate.json and Log.json.
"""

import json
import math
from typing import Any

from cnnsim.support import Floats
from tactile.events.event import Event
from tactile.recording.schema import INFO, NOTES

NUMBER, WHOLE, TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"title": title, "type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_TIME, _DURATION = _object("time", sec=WHOLE, nsec=WHOLE), _object("duration", sec=WHOLE, nsec=WHOLE)
_COLOR = _object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
_POSE = _object(
    "foxglove.Pose", position=_object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER),
    orientation=_object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER),
)  # fmt: skip
_ARROW = _object(
    "foxglove.ArrowPrimitive", pose=_POSE, shaft_length=NUMBER, shaft_diameter=NUMBER, head_length=NUMBER,
    head_diameter=NUMBER, color=_COLOR,
)  # fmt: skip
_WORDS = _object(
    "foxglove.TextPrimitive", pose=_POSE, billboard={"type": "boolean"}, font_size=NUMBER,
    scale_invariant={"type": "boolean"}, color=_COLOR, text=TEXT,
)  # fmt: skip
_EMPTY = {name: {"type": "array"} for name in ("cubes", "spheres", "cylinders", "lines", "triangles", "models")}
_ENTITY = _object(
    "foxglove.SceneEntity", timestamp=_TIME, frame_id=TEXT, id=TEXT, lifetime=_DURATION,
    frame_locked={"type": "boolean"}, metadata=_list(_object("foxglove.KeyValuePair", key=TEXT, value=TEXT)),
    arrows=_list(_ARROW), texts=_list(_WORDS), **_EMPTY,
)  # fmt: skip
_DELETION = _object("foxglove.SceneEntityDeletion", timestamp=_TIME, type=WHOLE, id=TEXT)
SCENE_NAME = "foxglove.SceneUpdate"
SCENE = json.dumps(_object(SCENE_NAME, deletions=_list(_DELETION), entities=_list(_ENTITY)))
"""JSON schema of foxglove.SceneUpdate."""
LOG = NOTES["/log"][1].decode()
"""JSON schema of foxglove.Log."""
BLUE, BLACK = {"r": 0.1, "g": 0.4, "b": 1.0, "a": 1.0}, {"r": 0.5, "g": 0.5, "b": 0.5, "a": 1.0}


def arrows_scene(finger: str, ns: int, lines: Floats, pitch: float) -> bytes:
    """Return a scene with an arrow along each line (n, 2, 3) [m]."""
    arrows = []
    for (x, y, z), (to_x, to_y, _) in lines.tolist():
        length, angle = math.hypot(to_x - x, to_y - y), math.atan2(to_y - y, to_x - x)
        if length > 0.02 * pitch:
            turned = {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
            arrows.append({
                "pose": {"position": {"x": x, "y": y, "z": z}, "orientation": turned}, "shaft_length": 0.7 * length,
                "shaft_diameter": pitch / 12, "head_length": 0.3 * length, "head_diameter": pitch / 6, "color": BLUE,
            })  # fmt: skip
    return _scene(finger, ns, arrows=arrows)


def text_scene(finger: str, ns: int, text: str, place: tuple[float, float, float]) -> bytes:
    """Return a scene with a text of the size and at the ``place`` (x, y, size) [m]; an empty one removes it."""
    x, y, size = place
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    words = {
        "pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": upright}, "billboard": True,
        "font_size": size, "scale_invariant": False, "color": BLACK, "text": text,
    }  # fmt: skip
    return _scene(finger, ns, texts=[words] if text else [])


def _scene(finger: str, ns: int, **parts: Any) -> bytes:
    entity = {
        "timestamp": stamp(ns), "frame_id": finger, "id": finger, "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True, "metadata": [], "arrows": [], "texts": [], **{name: [] for name in _EMPTY}, **parts,
    }  # fmt: skip
    return json.dumps({"deletions": [], "entities": [entity]}, allow_nan=False).encode()


def log_message(event: Event, ns: int) -> bytes:
    """Return a log line of an event."""
    line = {"timestamp": stamp(ns), "level": INFO, "message": event.words, "name": event.finger, "file": "", "line": 0}
    return json.dumps(line, ensure_ascii=False).encode()


def stamp(ns: int) -> dict[str, int]:
    """Return a time [ns] as seconds and nanoseconds."""
    return {"sec": ns // 10**9, "nsec": ns % 10**9}
