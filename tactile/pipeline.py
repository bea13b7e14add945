"""The tactile pipeline: touch flows one way. Start reading here."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import perf_counter

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import Source
from tactile.events.code import Code, hand_code
from tactile.events.events import Event
from tactile.finger import Finger, Settings
from tactile.inverse.localise import Load
from tactile.texture.figures import TextureFigures


@dataclass(frozen=True)
class Report:
    """Everything known after one frame of one finger. ``load`` is None for arrays that measure force themselves."""

    array: TaxelArray
    frame: Frame
    code: Code
    load: Load | None
    texture: TextureFigures
    events: tuple[Event, ...]


Sink = Callable[[Report], None]


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
        code = finger.taxels.code
        hand = hand_code([one.taxels.code for one in fingers]) if happened else 0
        latency = perf_counter() - arrived
        events = tuple(Event.of(frame, finger.array, code, hand, what, latency, load) for what in happened)
        report = Report(finger.array, frame, code, load, texture, events)
        for sink in sinks:
            sink(report)
