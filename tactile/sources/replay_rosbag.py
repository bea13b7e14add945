"""PapillArray recordings in ROS bags (1 and 2), read with the `rosbags` library.

A sensor's topic carries messages with ``tus`` (device time [us]) and ``pillars``, each with ``fX``, ``fY``, ``fZ`` [N];
bags name the type papillarray_ros_v2/SensorState or sensor_interfaces/SensorState. Frames get the time at which the bag
has them, counted from the first.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from cnnsim.support import InputError
from cnnsim.support.names import LONGEST
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import Provenance
from tactile.sources.replay_pillars import PILLAR_PITCH

KIND = "SensorState"


@dataclass(frozen=True)
class BagReplay:
    """The sensors of a bag, as a ``Source`` of force frames, read again each time.

    ``others``: what the bag holds besides, in words; ``start_ns``: time of its first frame since 1970 [ns].
    """

    path: Path
    topics: tuple[str, ...]
    arrays: tuple[TaxelArray, ...]
    frames: int
    others: tuple[str, ...] = ()
    start_ns: int | None = None
    modulus: None = None

    @property
    def provenance(self) -> Provenance:
        """A device's readings, with its offsets."""
        return Provenance(untared=True, start_ns=self.start_ns)

    @property
    def title(self) -> str:
        """The bag's name."""
        return self.path.stem

    def __iter__(self) -> Iterator[Frame]:
        counts, start = [0] * len(self.topics), None
        for topic, stamp, message in _messages(self.path, self.topics):
            finger = self.topics.index(topic)
            start = stamp if start is None else start
            force = np.array([(p.fX, p.fY, p.fZ) for p in message.pillars], dtype=np.float64)
            values = force.reshape(*self.arrays[finger].shape, 3)
            t_device = float(getattr(message, "tus", math.nan)) * 1e-6
            valid = np.asarray(np.isfinite(values).all(-1))
            yield Frame(finger, (stamp - start) * 1e-9, counts[finger], values, valid, t_device)
            counts[finger] += 1


def read_bag(path: Path) -> BagReplay:
    """Find the sensors in a bag: a .bag file, a .db3 file or the folder of a ROS 2 bag.

    Raises:
        InputError: no such bag, one that cannot be read, or one without a sensor.
    """
    folder = path.parent if path.suffix == ".db3" else path
    try:
        with _reader(folder) as bag:
            found = [c for c in bag.connections if c.msgtype.endswith(f"/{KIND}") and c.msgcount]
            kinds = sorted({c.msgtype for c in bag.connections})
            every = {c.topic for c in bag.connections}
    except (AnyReaderError, OSError) as error:
        raise InputError(f"{path}: cannot be read as a ROS bag: {error}") from error
    if not found:
        raise InputError(f"{path}: messages of {', '.join(kinds) or 'no kind'}; {KIND} with pillars wanted")
    topics = tuple(sorted({connection.topic for connection in found}))
    arrays, starts, others = [], [], sorted(f"topic {one}" for one in every - set(topics))
    for topic in topics:
        _, stamp, message = next(_messages(folder, (topic,)))
        starts.append(stamp)
        fields = sorted({*vars(message)} - {"tus", "pillars"})
        others += [f"{topic} {name}" for name in fields if not name.startswith("_")]
        side = math.isqrt(len(message.pillars))
        if side == 0 or side * side != len(message.pillars):
            raise InputError(f"{path}: topic {topic} has {len(message.pillars)} pillars, a square number wanted")
        arrays.append(TaxelArray(_finger(topic), side, side, PILLAR_PITCH, 0.0, quantity="force"))
    count = sum(connection.msgcount for connection in found)
    return BagReplay(folder, topics, tuple(arrays), count, tuple(others), min(starts))


def _finger(topic: str) -> str:
    """Return a topic as a finger's name: hub_0-sensor_1."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", topic).strip("-")[:LONGEST] or "sensor"


def _reader(path: Path) -> AnyReader:
    return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))


def _messages(path: Path, topics: tuple[str, ...]) -> Iterator[tuple[str, int, Any]]:
    with _reader(path) as bag:
        wanted = [connection for connection in bag.connections if connection.topic in topics]
        for connection, stamp, raw in bag.messages(wanted):
            yield connection.topic, stamp, bag.deserialize(raw, connection.msgtype)
