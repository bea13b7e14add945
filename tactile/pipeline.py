"""The tactile pipeline: touch flows one way. Start reading at `run`."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from cnnsim.machine import UniversalMachine
from cnnsim.program_file import load_program
from tactile.calibration import Tare
from tactile.encoding import CONTACT, SHEAR, Code, Threshold, decode, encode, hand_code
from tactile.events import Event, meaning, slip_meaning
from tactile.frame import Frame, TaxelArray
from tactile.localise import Load, localise
from tactile.slip import SlipWatch
from tactile.sources.base import Source
from tactile.texture import Texture, TextureFigures


@dataclass(frozen=True)
class Settings:
    """What a user can choose; None means: as the array's quantity asks for.

    ``shear`` and ``contact`` thresholds in the unit of the signal; ``window`` T [frames] and ``floor`` (normal signal)
    of the texture figures; ``tare`` frames at the start that are averaged away; ``backend`` of the machine.
    """

    shear: Threshold | None = None
    contact: Threshold | None = None
    window: int = 128
    floor: float | None = None
    tare: int = 0
    backend: str = "cpu"


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
    for frame in source:
        arrived = perf_counter()
        finger = fingers[frame.finger]
        frame = finger.tare(frame)  # from here on only the calibrated frame exists
        load = finger.locate(frame)
        before, changed = finger.code, finger.encode(frame)
        figures = finger.texture.update(np.where(frame.valid[..., None], frame.values, np.nan))
        happened = [meaning(before, finger.code)] if changed else []
        slip = None if load is None else finger.slip.update(frame.t, load, bool(finger.code.contact.any()))
        happened += [slip_meaning(slip)] if slip else []
        hand = hand_code([one.code for one in fingers]) if happened else 0
        events = tuple(
            Event(
                frame.t, finger.array.name, frame.sequence, finger.code.arrows(), finger.code.ternary(), hand, what,
                perf_counter() - arrived, load,
            )
            for what in happened
        )  # fmt: skip
        report = Report(finger.array, frame, finger.code, load, figures, events)
        for sink in sinks:
            sink(report)


@dataclass
class Finger:
    """What has to be remembered of one finger between frames: its machine's planes, its code, its averages."""

    array: TaxelArray
    modulus: float | None
    settings: Settings
    tare: Tare = field(init=False)
    texture: Texture = field(init=False)
    slip: SlipWatch = field(init=False, default_factory=SlipWatch)
    code: Code = field(init=False)

    def __post_init__(self) -> None:
        quantity, settings, shape = self.array.quantity, self.settings, self.array.shape
        self.shear = settings.shear or SHEAR[quantity]
        self.contact = settings.contact or CONTACT[quantity]
        floor = self.contact.dead_band if settings.floor is None else settings.floor
        self.tare, self.texture = Tare(settings.tare), Texture(settings.window, floor)
        nothing = np.zeros(shape, dtype=np.int8)
        self.code = Code(nothing, nothing, nothing.astype(bool))
        self._positions = self.array.positions()
        self._machine = UniversalMachine(settings.backend, "float64")
        comparators = {
            "plus": self.shear.comparator(1),
            "minus": self.shear.comparator(-1),
            "press": self.contact.comparator(1),
        }
        self._event_code = load_program("event-code", templates=comparators)
        self._inverse = None
        if quantity == "strain":
            assert self.modulus is not None
            numbers = {"depth": self.array.depth, "modulus": self.modulus, "floor": self.contact.dead_band}
            self._inverse = load_program("locate-strain", parameters=numbers)
        elif quantity == "stress":
            numbers = {"depth": self.array.depth, "floor": self.contact.dead_band}
            self._inverse = load_program("locate-stress", parameters=numbers)

    def locate(self, frame: Frame) -> Load | None:
        """Return the load under this finger: the inverse in every cell, then the taxels' consensus."""
        if self._inverse is None:
            return None
        values = np.where(frame.valid[..., None], frame.values, np.nan)
        planes = self._machine.run(
            self._inverse, **{name: values[..., i] for i, name in enumerate(self._inverse.inputs)}
        )
        found = tuple(planes.values())
        return localise(self._positions, found[:4], found[4:] or None, self.array.depth)

    def encode(self, frame: Frame) -> bool:
        """Run the comparators on the frame, remember the code, and return whether it has changed."""
        planes = self._machine.run(self._event_code, **encode(frame, self.array.quantity, self.shear, self.contact))
        self.code = decode(planes)
        return bool(planes["moved"])
