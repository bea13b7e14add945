"""PapillArray recordings in ROS bags (1 and 2), read with the `rosbags` library.

The topic of a sensor has messages with ``tus`` (device time [us]) and ``pillars``, each with ``fX``, ``fY``, ``fZ``
[N]; the type is papillarray_ros_v2/SensorState or sensor_interfaces/SensorState. Frames have the stamp of the message
header, counted from the first, its sequence number (ROS 1) and its flags ``is_sd_active``, ``is_ref_loaded`` and
``is_contact``; without a header the time of recording, and a count.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from heapq import heappop, heappush
from importlib.util import find_spec
from pathlib import Path
from threading import Timer
from typing import IO, Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.extras import install_line
from cnnsim.support.files import LONGEST_NAME
from cnnsim.support.limits import one_line
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import Provenance
from tactile.sources.bag_process import FRAME, KIND
from tactile.sources.replay_pillars import PillarStream, pillar_array

LATE = 0.5
"""[s] Largest delay of a message behind one with a later stamp."""
PATIENCE = 4.0
"""[s] Time limit for reading the index of a bag."""


class BagFrames:
    """The frames of all sensors of a bag, read again each time."""

    def __init__(self, path: Path, arrays: tuple[TaxelArray, ...]) -> None:
        self._path, self._arrays = path, arrays

    def __iter__(self) -> Iterator[Frame]:
        waiting: list[tuple[int, int, Frame]] = []  # messages are stored in the order of arrival, not of their stamps
        with _bag(self._path) as (about, out):
            start, latest = min(about["starts"]), 0.0
            for number in range(about["frames"]):
                finger, stamp, tus, sequence, flags, pillars = FRAME.unpack(_exactly(out, FRAME.size))
                force = np.frombuffer(_exactly(out, 24 * pillars), "<f8").reshape(*self._arrays[finger].shape, 3)
                valid = np.asarray(np.isfinite(force).all(-1))
                t = (stamp - start) * 1e-9
                frame = Frame(finger, t, sequence, force.copy(), valid, tus * 1e-6, flags)
                heappush(waiting, (stamp, number, frame))
                latest = max(latest, t)
                while waiting[0][2].t < latest - LATE:
                    yield heappop(waiting)[2]
        while waiting:
            yield heappop(waiting)[2]


def read_bag(path: Path) -> PillarStream:
    """Find the sensors in a bag: a .bag file, a .db3 file or the folder of a ROS 2 bag.

    Raises:
        InputError: no such bag, one that cannot be read, or one without a sensor.
    """
    folder = path.parent if path.suffix == ".db3" else path
    with _bag(folder) as (about, _):
        pass
    if not about["topics"]:
        raise InputError(f"{path}: messages of {', '.join(about['kinds']) or 'no kind'}; {KIND} with pillars wanted")
    arrays = tuple(
        pillar_array(_finger(topic), pillars, f"{path}: topic {topic}")
        for topic, pillars in zip(about["topics"], about["pillars"], strict=True)
    )
    known, others = Provenance(untared=True, start_ns=min(about["starts"])), tuple(about["others"])
    return PillarStream(folder.stem, arrays, None, about["frames"], BagFrames(folder, arrays), known, others=others)


def _finger(topic: str) -> str:
    """Return the finger name of a topic, such as hub_0-sensor_1."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", topic).strip("-")[:LONGEST_NAME] or "sensor"


@contextmanager
def _bag(path: Path) -> Iterator[tuple[dict[str, Any], IO[bytes]]]:
    """Return the contents of a bag and the stream of its frames, from a process with limits."""
    if find_spec("rosbags") is None:
        raise InputError(f"a ROS bag needs rosbags, which is not installed: {install_line('serial')}")
    # no memory for threads of linear algebra; no path of this project before the installed library
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "tactile.sources.bag_process", str(path.absolute())], stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stderr is not None
    waiting = Timer(PATIENCE, process.kill)
    waiting.start()
    try:
        with one_line(path, "a ROS bag"):
            head = process.stdout.readline()
            waiting.cancel()
            if not head:
                said = process.stderr.read().decode(errors="replace").strip().rpartition("\n")[2]
                raise InputError(f"{path}: cannot be read as a ROS bag: {said or f'nothing found in {PATIENCE:g} s'}")
            yield json.loads(head), process.stdout
    finally:
        waiting.cancel()
        process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()


def _exactly(out: IO[bytes], count: int) -> bytes:
    data = out.read(count)
    if len(data) < count:
        raise ValueError("it ends within a frame")
    return data
