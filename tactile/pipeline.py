"""The tactile pipeline: frames are calibrated, located, watched for events, and reported. Start reading here."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled
from cnnsim.support.progress import watched_by
from tactile.calibration.live_tare import TareMode, TareNote
from tactile.calibration.tare_check import TareCheck
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Source
from tactile.events.code import Code
from tactile.events.event import Event
from tactile.events.event_builder import EventBuilder
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.settings import Settings
from tactile.texture.figures import TextureFigures
from tactile.thresholds.levels import Levels
from tactile.thresholds.threshold import CONTACT, SHEAR


@dataclass(frozen=True)
class FrameReport:
    """Everything known after one frame of one finger.

    ``events`` that this frame tells to have begun, ``ended`` those it tells to be over (see `Event.key`); ``tares``:
    what has become of tares, ``tare`` what the first took away; ``said``: changed outputs of the user's programs by
    name; ``levels``: where the taxels' comparators switch in this frame.
    """

    array: TaxelArray
    frame: Frame
    code: Code
    load: Load
    texture: TextureFigures
    events: tuple[Event, ...]
    ended: tuple[Event, ...] = ()
    tares: tuple[TareNote, ...] = ()
    tare: TareCheck | None = None
    said: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    levels: Levels | None = None

    def __repr__(self) -> str:
        happened = [event.words for event in self.events]
        return f"FrameReport({self.array.name}, t={self.frame.t:g}, {happened}, {self.load!r})"


WARM = 20.0
"""Times its largest level that the made-up touch of `warm_up` presses."""
WARM_SCRIPT = (
    [(0, 0, 0, 0)] * 42 + [(0, 0, 1, 0)] * 30 + [(0.02 * n, 0, 1, 0) for n in range(25)]
    + [(0.5, 0.05 * n, 1, 0) for n in range(12)] + [(0, 0, 1, 1)] * 4 + [(0, 0, 0, 0)] * 42
)  # fmt: skip
"""Pull, way along x in pitches, pressing, and pressing of a second load of its frames, one each 20 ms: idle for two
tares before and after."""

Sink = Callable[[FrameReport], None]


def make_fingers(arrays: Iterable[TaxelArray], modulus: float | None, settings: Settings) -> list[Finger]:
    """Return the fingers that `run` takes frames through, before the first of them."""
    return [Finger(array, modulus, settings, number) for number, array in enumerate(arrays)]


@spelled()
def run(source: Source, settings: Settings, sinks: Iterable[Sink], fingers: list[Finger] | None = None) -> None:
    """Take every frame of the source through the pipeline and hand the report to each sink.

    ``fingers``: new ones of the source's arrays, where they had to be there before the first frame.

    Raises:
        InputError: a path in the place of a source, no settings, what is no list of functions; as the source itself.
    """
    if isinstance(source, str | Path):
        raise InputError(f"run({str(source)!r}, ...); a source of frames wanted: open_source({str(source)!r})")
    if not isinstance(settings, Settings):
        raise InputError(f"settings {shown(settings)}; Settings() wanted, or with what is to be another")
    sinks = tuple(sinks) if isinstance(sinks, Iterable) else sinks
    if not isinstance(sinks, tuple) or not all(map(callable, sinks)):
        raise InputError(f"sinks {shown(sinks)}; a list of functions wanted, each of which takes a FrameReport")
    if fingers is None:
        fingers = make_fingers(source.arrays, source.modulus, settings)
    told = EventBuilder(fingers)
    requests = getattr(source, "tare_requests", None)  # of sources that people can talk to
    with watched_by(None):  # of long work: a frame's programs are none, and a bar would count their steps
        for raw in source:
            arrived = perf_counter()
            while requests:
                force = requests.popleft()
                for one in fingers:
                    one.tare.ask(force)
            finger = fingers[raw.finger]
            frame = finger.calibrate(raw)
            load = finger.locate(frame)
            happened = finger.notice(frame, load)
            texture = finger.feel(frame, load)
            begun, ended = told.events(finger, frame, load, happened, arrived) if happened else ((), ())
            report = FrameReport(
                finger.array,
                frame,
                finger.taxels.code,
                load,
                texture,
                begun,
                ended,
                *_tares(finger),
                finger.said(),
                finger.levels,
            )
            for sink in sinks:
                sink(report)


def _tares(finger: Finger) -> tuple[tuple[TareNote, ...], TareCheck | None]:
    """Return what became of tares with this frame, and what the first took away."""
    notes = finger.tare_notes()
    return notes, next((note.check for note in notes if note.check is not None), None)


def warm_up(
    arrays: tuple[TaxelArray, ...], modulus: float | None, settings: Settings, sinks: Iterable[Sink] = ()
) -> None:
    """Run on a made-up grip of every array, so that nothing is compiled or refused once real frames arrive.

    It goes the way of a real one: nothing, so that a tare is taken, a firm touch, a pull, a slip, where loads are
    located two at once and a taxel that contradicts them, and nothing again, above every level of the settings.
    """
    made = []
    for finger, array in enumerate(arrays):
        size = WARM * max(
            threshold.dead_band + threshold.hysteresis
            for threshold in (SHEAR[array.quantity], CONTACT[array.quantity], settings.shear, settings.contact)
            if threshold is not None
        )
        touch = _touch(array, modulus) * size
        valid = np.ones(array.shape, bool)
        made += [Frame(finger, 0.02 * n, n, values, valid) for n, values in enumerate(touch)]
    tare: TareMode = "off" if settings.tare == "off" else "auto"
    requests = deque([False] * (tare == "auto"))
    stream = FrameStream("made up", arrays, modulus, len(made), made, tare_requests=requests)
    run(stream, replace(settings, tare=tare), sinks)


def _touch(array: TaxelArray, modulus: float | None) -> Floats:
    """Return the frames (n, rows, cols, 3) of a made-up grip: of a point load where loads are located, largest 1."""
    if array.quantity == "force":
        pull, _, press, _ = np.array(WARM_SCRIPT).T
        return np.broadcast_to(np.stack([pull, 0 * pull, press], -1)[:, None, None], (len(pull), *array.shape, 3))
    from tactile.elastic.halfspace import point_load_strain, point_load_stress  # only here

    frames = np.zeros((len(WARM_SCRIPT), *array.shape, 3))
    places, middle = array.positions(), array.positions().mean(axis=(0, 1))
    for n, (pull, way, press, second) in enumerate(WARM_SCRIPT):
        load = [[middle[0] + way * array.pitch, middle[1], pull, 0.0, press], [*places[0, 0], 0.0, 0.0, second]]
        if array.quantity == "strain":
            frames[n] = point_load_strain(places, array.depth, load, modulus or 1.0)
        else:
            frames[n] = point_load_stress(places, array.depth, load)
        if second and n % 2:  # a taxel that is stuck
            frames[n, -1, -1] = np.abs(frames[n]).max()
    return frames / max(float(np.abs(frames).max()), 1e-300)
