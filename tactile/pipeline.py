"""The tactile pipeline: calibrate, locate, detect events, report, for every frame. Start reading here."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled
from cnnsim.support.progress import watched_by
from tactile.calibration.live_tare import TareMode
from tactile.calibration.tare_check import TareCheck, TareNote
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
    """Results of one frame of one finger.

    ``events``: events that begin with this frame; ``ended``: events that end with it (see `Event.key`); ``tares``:
    changes of the tare; ``tare``: the offsets of the first tare; ``outputs``: changed outputs of the user's programs by
    name; ``levels``: switching levels of the comparators.
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
    outputs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    levels: Levels | None = None

    def __repr__(self) -> str:
        happened = [event.words for event in self.events]
        return f"FrameReport({self.array.name}, t={self.frame.t:g}, {happened}, {self.load!r})"


WARM = 20.0
"""Pressing of the made-up grip of `warm_up` over its largest level."""
WARM_SCRIPT = (
    [(0, 0, 0, 0)] * 42 + [(0, 0, 1, 0)] * 30 + [(0.02 * n, 0, 1, 0) for n in range(25)]
    + [(0.5, 0.05 * n, 1, 0) for n in range(12)] + [(0, 0, 1, 1)] * 4 + [(0, 0, 0, 0)] * 42
)  # fmt: skip
"""Frames of the made-up grip, 20 ms apart: pull, position along x in pitches, pressing, pressing of a second load. Idle
for two tares before and after."""

Sink = Callable[[FrameReport], None]


def make_fingers(arrays: Iterable[TaxelArray], modulus: float | None, settings: Settings) -> list[Finger]:
    """Return the fingers of `run`, before the first frame."""
    return [Finger(array, modulus, settings, number) for number, array in enumerate(arrays)]


@spelled()
def run(source: Source, settings: Settings, sinks: Iterable[Sink], fingers: list[Finger] | None = None) -> None:
    """Pass every frame of the source through the pipeline and the report to each sink.

    Settings that are None follow from the source, as those of `tactile run`. ``fingers``: the fingers of the source's
    arrays, if they were made before the first frame.

    Raises:
        InputError: a path instead of a source, invalid settings or sinks; as the source itself.
    """
    if isinstance(source, str | Path):
        raise InputError(f"run({str(source)!r}, ...); a source of frames wanted: open_source({str(source)!r})")
    if not isinstance(settings, Settings):
        raise InputError(f"settings {shown(settings)}; Settings(...) wanted")
    sinks = tuple(sinks) if isinstance(sinks, Iterable) else sinks
    if not isinstance(sinks, tuple) or not all(map(callable, sinks)):
        raise InputError(f"sinks {shown(sinks)}; a list of functions of a FrameReport wanted")
    with watched_by(None):  # no progress bar for the programs of a frame
        for report in reports(source, settings, fingers):
            for sink in sinks:
                sink(report)


def reports(source: Source, settings: Settings, fingers: list[Finger] | None = None) -> Iterator[FrameReport]:
    """Yield the report of every frame of the source; arguments as `run`.

    Raises:
        InputError: as the source itself.
    """
    settings = settings.of(source)
    if fingers is None:
        fingers = make_fingers(source.arrays, source.modulus, settings)
    events = EventBuilder(fingers)
    requests = getattr(source, "tare_requests", None)  # of sources that take requests
    for raw in source:
        arrived = perf_counter()
        while requests:
            force = requests.popleft()
            for one in fingers:
                one.tare.ask(force)
        finger = fingers[raw.finger]
        frame = finger.calibrate(raw)
        closed = () if finger.broken is None else events.close(finger, finger.broken)
        load = finger.locate(frame)
        transitions = finger.detect(frame, load)
        texture = finger.texture(frame, load)
        begun, ended = events.build(finger, frame, load, transitions, arrived) if transitions else ((), ())
        yield FrameReport(
            finger.array,
            frame,
            finger.taxels.code,
            load,
            texture,
            begun,
            (*closed, *ended),
            *_tares(finger),
            finger.program_outputs(),
            finger.levels,
        )


def _tares(finger: Finger) -> tuple[tuple[TareNote, ...], TareCheck | None]:
    """Return the changes of the tare in this frame, and the offsets of the first tare."""
    notes = finger.tare_notes()
    return notes, next((note.check for note in notes if note.check is not None), None)


def warm_up(
    arrays: tuple[TaxelArray, ...], modulus: float | None, settings: Settings, sinks: Iterable[Sink] = ()
) -> None:
    """Run the pipeline on a made-up grip of every array, so that all loops are compiled before the first real frame.

    The grip has all stages of a real one: idle frames for a tare, a firm touch, a pull, a slip, two loads at once and a
    stuck taxel, and idle frames again, above every level of the settings.
    """
    from tactile.core.noise_numba import is_noise  # numba is slow to import

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
    is_noise(np.zeros((1, 1, 3)), np.zeros((1, 1, 3)))  # the made-up grip has no noise


def _touch(array: TaxelArray, modulus: float | None) -> Floats:
    """Return the frames (n, rows, cols, 3) of the made-up grip, of a point load where loads are located, largest 1."""
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
        if second and n % 2:  # a stuck taxel
            frames[n, -1, -1] = np.abs(frames[n]).max()
    return frames / max(float(np.abs(frames).max()), 1e-300)
