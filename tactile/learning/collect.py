"""Examples for learned detectors: planes of labelled fingers over time, with the known times of the event."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cnnsim.support import Array, Floats, InputError
from tactile import pipeline
from tactile.core.frame import Frame
from tactile.core.source import Source, with_frames
from tactile.learning.front import TOUCH, Front
from tactile.pipeline import FrameReport
from tactile.score.labels import LabelledSource
from tactile.settings import Settings

APART = 0.005
"""[s] Least time between two kept frames, a tenth of the largest error of an onset."""


@dataclass(frozen=True)
class Example:
    """A finger of a recording: planes (n, planes, rows, cols) at times ``t`` (n,) [s].

    ``known``: onsets of the event, none where it does not happen; ``until``: end of the last contact [s], inf if
    unknown; ``array``: what sets its array apart from others.
    """

    recording: str
    finger: str
    array: str
    t: Floats
    planes: Array
    touch: Array
    known: tuple[float, ...]
    until: float


def known_times(case: LabelledSource, kind: str) -> dict[int, tuple[tuple[float, ...], float]]:
    """Return for each labelled finger the times of the event, and when its last contact ends, inf if unknown."""
    found: dict[int, tuple[tuple[float, ...], float]] = {}
    for label in case.labels:
        times, until = found.get(label.finger, ((), -np.inf))
        mine = (label.times[kind],) if kind in label.times else ()
        found[label.finger] = (*times, *mine), max(until, label.times.get("release", np.inf))
    return found


def collect(
    cases: Iterable[LabelledSource], kind: str, front: Front, settings: Callable[[Source], Settings]
) -> list[Example]:
    """Run recordings through the pipeline and return the planes of their labelled fingers.

    Raises:
        InputError: readings that are not numbers, a finger without any tare.
    """
    found = list[Example]()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tap.toml"
        path.write_text(front.tap(), encoding="utf-8")
        for case in cases:
            found += _examples(case, kind, front, replace(settings(case.source), programs=(str(path),)))
    return found


def _examples(case: LabelledSource, kind: str, front: Front, settings: Settings) -> list[Example]:
    fingers = {case.source.arrays[number].name: times for number, times in known_times(case, kind).items()}
    kept: dict[str, list[tuple[float, Array, Array]]] = {name: [] for name in fingers}
    now: dict[str, tuple[Array, Array]] = {}
    inputs = front.inputs
    read, touched = [inputs.index(name) for name in front.planes], inputs.index(TOUCH)
    marked = [inputs.index(name) for name in front.kept]

    def sink(report: FrameReport) -> None:
        name, t = report.array.name, report.frame.t
        if name not in kept:
            return
        if outputs := report.outputs.get("tap"):
            planes = np.array([outputs[plane] for plane in inputs])
            before = now[name][1] if name in now else np.zeros((len(marked), *planes.shape[1:]), bool)
            now[name] = planes, (before | (planes[marked] > 0)) & (planes[touched] > 0)
        if name in now and (not kept[name] or t - kept[name][-1][0] >= APART):
            planes, was = now[name]
            both = np.concatenate([planes[read], np.where(was, 1.0, -1.0)]).astype(np.float16)
            kept[name].append((t, both, planes[touched] > 0))

    pipeline.run(with_frames(case.source, _whole(case)), settings, [sink])
    found = []
    for array in case.source.arrays:
        if array.name in fingers:
            if not kept[array.name]:
                raise InputError(f"{case.name}, finger {array.name!r}: never still for a tare; 0.2 s of rest wanted")
            t, planes, touch = map(np.array, zip(*kept[array.name], strict=True))
            key = f"{array.name} {array.rows} x {array.cols} {array.quantity}"
            found.append(Example(case.name, array.name, key, t, planes, touch, *fingers[array.name]))
    return found


def _whole(case: LabelledSource) -> Iterator[Frame]:
    for frame in case.source:
        if not (frame.valid.all() and np.isfinite(frame.values).all()):
            where = f"{case.name}, finger {case.source.arrays[frame.finger].name!r}, {frame.t:.3f} s"
            raise InputError(f"{where}: readings are missing or no numbers; complete frames wanted")
        yield frame
