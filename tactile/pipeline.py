"""The tactile pipeline: frames are calibrated, located, watched for events, and reported. Start reading here."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from tactile.calibration.tare_check import TareCheck
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Source
from tactile.events.code import Code, hand_code
from tactile.events.event import Event
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.settings import Settings
from tactile.texture.figures import TextureFigures


@dataclass(frozen=True)
class FrameReport:
    """Everything known after one frame of one finger.

    ``load`` is None for arrays that measure force themselves; ``tare``: what the tare took away, in the report of the
    last frame that it averaged, else None.
    """

    array: TaxelArray
    frame: Frame
    code: Code
    load: Load | None
    texture: TextureFigures
    events: tuple[Event, ...]
    tare: TareCheck | None = None

    def __repr__(self) -> str:
        happened = [event.words for event in self.events]
        return f"FrameReport({self.array.name}, t={self.frame.t:g}, {happened}, {self.load!r})"


Sink = Callable[[FrameReport], None]


def run(source: Source, settings: Settings, sinks: Iterable[Sink]) -> None:
    """Take every frame of the source through the pipeline and hand the report to each sink."""
    sinks = tuple(sinks)
    fingers = [Finger(array, source.modulus, settings) for array in source.arrays]
    for raw in source:
        arrived = perf_counter()
        finger = fingers[raw.finger]
        frame = finger.calibrate(raw)
        load = finger.locate(frame)
        happened = finger.notice(frame, load)
        texture = finger.feel(frame)
        array, code = finger.array, finger.taxels.code
        hand = hand_code([one.taxels.code for one in fingers]) if happened else 0
        latency = perf_counter() - arrived
        events = tuple(
            Event(frame.t, array.name, frame.sequence, kind, data, code.arrows(), code.ternary(), hand, latency, load)
            for kind, data in happened
        )
        report = FrameReport(array, frame, code, load, texture, events, finger.tared)
        for sink in sinks:
            sink(report)


def warm_up(
    arrays: tuple[TaxelArray, ...], modulus: float | None, settings: Settings, sinks: Iterable[Sink] = ()
) -> None:
    """Run on a made-up firm touch of every array, so that nothing is compiled or refused once real frames arrive."""
    touch = [
        Frame(finger, 0.0, n, np.full((*array.shape, 3), 0.01), np.ones(array.shape, bool))
        for finger, array in enumerate(arrays)
        for n in range(2)
    ]
    run(FrameStream("made up", arrays, modulus, len(touch), touch), replace(settings, tare=0), sinks)
