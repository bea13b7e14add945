"""PapillArray recordings in ROS bags (1 and 2), read with the `rosbags` library.

The topic of a sensor has messages with ``tus`` (device time [us]) and ``pillars``, each with ``fX``, ``fY``, ``fZ``
[N]; the type is papillarray_ros_v2/SensorState or sensor_interfaces/SensorState. Frames have the stamp of the message
header, counted from the first, its sequence number (ROS 1) and its flags ``is_sd_active``, ``is_ref_loaded`` and
``is_contact``; without a header the time of recording, and a count. Header stamps with a fault are replaced by the time
of recording or of the device.
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

from cnnsim.support import Floats, InputError
from cnnsim.support.command_files import note_read
from cnnsim.support.extras import install_line
from cnnsim.support.files import LONGEST_NAME
from cnnsim.support.limits import one_line
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import ForeignFileError, Provenance
from tactile.sources.bag_process import FRAME, KIND, NONE
from tactile.sources.replay_pillars import PillarStream, pillar_array
from tactile.sources.stamps import UNIX, settled

LATE = 0.5
"""[s] Largest delay of a message behind one with a later stamp."""
PATIENCE = 8.0
"""[s] Time limit for reading the index of a bag."""
WHOLE = 30
"""Number of these limits for reading a whole topic."""


class BagFrames:
    """The frames of all sensors of a bag, read again each time; ``times`` [s] of the frames of each sensor."""

    def __init__(self, path: Path, arrays: tuple[TaxelArray, ...], times: list[Floats]) -> None:
        self._path, self._arrays, self._times = path, arrays, times

    def __iter__(self) -> Iterator[Frame]:
        waiting: list[tuple[float, int, Frame]] = []  # the messages of two sensors are stored in the order of arrival
        times = [iter(one.tolist()) for one in self._times]
        latest = 0.0
        with _bag(self._path) as (about, out):
            for number in range(about["frames"]):
                finger, _, _, tus, sequence, flags, pillars = FRAME.unpack(_exactly(out, FRAME.size))
                force = np.frombuffer(_exactly(out, 24 * pillars), "<f8").reshape(*self._arrays[finger].shape, 3)
                valid = np.asarray(np.isfinite(force).all(-1))
                t = next(times[finger])
                frame = Frame(finger, t, sequence, force.copy(), valid, tus * 1e-6, flags)
                heappush(waiting, (t, number, frame))
                latest = max(latest, t)
                while waiting[0][2].t < latest - LATE:
                    yield heappop(waiting)[2]
        while waiting:
            yield heappop(waiting)[2]


def read_bag(path: Path) -> PillarStream:
    """Find the sensors in a bag: a .bag, .db3 or .mcap file or the folder of a ROS 2 bag.

    Raises:
        InputError: no such bag, one that cannot be read, or one without a sensor.
    """
    folder = path.parent if path.suffix == ".db3" else path
    note_read(folder)
    with _bag(folder) as (about, out):
        stamps: list[list[tuple[int, int, float]]] = [[] for _ in about["topics"]]
        for _ in range(about["frames"]):
            finger, header, recorded, tus, _, _, pillars = FRAME.unpack(_exactly(out, FRAME.size))
            _exactly(out, 24 * pillars)
            stamps[finger].append((header, recorded, tus))
    if not about["topics"]:
        raise ForeignFileError(
            f"{path}: messages of {', '.join(about['kinds']) or 'no kind'}; {KIND} with pillars wanted"
        )
    arrays = tuple(
        pillar_array(_finger(topic), pillars, f"{path}: topic {topic}")
        for topic, pillars in zip(about["topics"], about["pillars"], strict=True)
    )
    times, start, note = _times(stamps)
    known, others = Provenance(untared=True, start_ns=start), tuple(about["others"])
    frames, notes = BagFrames(folder, arrays, times), (note,) if note else ()
    return PillarStream(folder.stem, arrays, None, about["frames"], frames, known, notes=notes, others=others)


def _times(stamps: list[list[tuple[int, int, float]]]) -> tuple[list[Floats], int, str]:
    """Return the times [s] of the messages of each topic, the Unix time [ns] at 0, and a note on a repair.

    ``stamps``: header [ns], recording [ns] and device [us] of every message. All topics have the same clock.
    """
    headers, recorded = ([np.array([one[k] for one in topic], np.int64) for topic in stamps] for k in (0, 1))
    start = min(int(topic.min()) for topic in recorded)
    bag: list[Floats] = [np.asarray((topic - start) * 1e-9, np.float64) for topic in recorded]
    if any((topic == NONE).any() for topic in headers):
        return bag, start, ""
    first = min(int(topic[0]) for topic in headers)
    clocks: list[Floats] = [np.where((topic == 0) & (first > 0), np.nan, (topic - first) * 1e-9) for topic in headers]
    device = [np.array([one[2] for one in topic]) * 1e-6 for topic in stamps]
    others = {"the bag": bag, "the device": [one - one[0] for one in device]}
    notes = []
    for n, clock in enumerate(clocks):
        notes.append(settled(clock, {name: one[n] for name, one in others.items()}, "header stamps")[1])
    if note := next(filter(None, notes), ""):
        name = next(name for name in others if note.endswith(f"{name} are used"))
        return others[name], start, note
    return clocks, start if first < UNIX < start else first, ""  # the time of a simulation is no Unix time


def _finger(topic: str) -> str:
    """Return the finger name of a topic, such as hub_0-sensor_1."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", topic).strip("-")[:LONGEST_NAME] or "sensor"


def table_of_bag(path: Path, topic: str) -> bytes:
    """Return the NPZ file of the messages of a topic, from a process with limits."""
    with _process(path, topic) as (head, out):
        return head + out.read()


@contextmanager
def _bag(path: Path) -> Iterator[tuple[dict[str, Any], IO[bytes]]]:
    """Return the contents of a bag and the stream of its frames."""
    with _process(path) as (head, out):
        yield json.loads(head), out


@contextmanager
def _process(path: Path, *topic: str) -> Iterator[tuple[bytes, IO[bytes]]]:
    """Return the first line of the output of the reader process (with a ``topic`` its first byte), and the rest."""
    if find_spec("rosbags") is None:
        raise InputError(f"a ROS bag needs rosbags, which is not installed: {install_line('serial')}")
    # no memory for threads of linear algebra; no path of this project before the installed library
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "tactile.sources.bag_process", str(path.absolute()), *topic],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stderr is not None
    waiting = Timer(PATIENCE * (WHOLE if topic else 1), process.kill)
    waiting.start()
    try:
        with one_line(path, "a ROS bag"):
            head = process.stdout.read(1) if topic else process.stdout.readline()
            waiting.cancel()
            if not head:
                said = process.stderr.read().decode(errors="replace").strip().rpartition("\n")[2]
                raise InputError(f"{path}: cannot be read as a ROS bag: {said or f'nothing found in {PATIENCE:g} s'}")
            yield head, process.stdout
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
