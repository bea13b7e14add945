"""Frames for control loops: tared taxels, load, code, events and slip margin, and the same as plain data."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import orjson

from cnnsim.support import Flags, Floats
from tactile.core.frame import TaxelArray
from tactile.events.code import Code
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.output.event_data import EventData, finite, load_data
from tactile.pipeline import FrameReport

FRICTION = 0.5
"""Coefficient of friction of the slip margin until a slip has been measured: silicone on smooth objects has more."""


@dataclass(frozen=True)
class StreamFrame:
    """One frame of one finger after the pipeline.

    ``t`` [s] since the start of the stream, ``unix_s`` [s] since 1970 (NaN if unknown), ``t_device`` [s] of the
    device's clock (NaN without one); ``values`` (rows, cols, 3): shear_x, shear_y, normal after the tare, in the unit
    of the array's quantity; ``valid`` (rows, cols); ``load``: forces Q, R, F [N] and their place; ``centre`` (x, y)
    [m]: centre of pressure, or place of the located load, NaN without one; ``slip_margin``: see `SlipMargins`;
    ``begun`` and ``ended``: events that begin and end with this frame.
    """

    finger: str
    t: float
    unix_s: float
    t_device: float
    sequence: int
    values: Floats
    valid: Flags
    load: Load
    code: Code
    slip_margin: float
    begun: tuple[Event, ...]
    ended: tuple[Event, ...]

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of pressure (x, y) [m]."""
        return self.load.x, self.load.y


class SlipMargins:
    """Slip margin of each finger: the distance of its tangential load from the limit of friction.

        m = 1 - |(Q, R)| / (mu F), 0 at the limit and beyond, 1 without tangential load

    It is NaN without contact, and for arrays that measure the normal alone.

    mu is ``friction`` until a slip has been measured on the finger; from then on |(Q, R)| / F at the latest slip.
    """

    def __init__(self, friction: float = FRICTION) -> None:
        self._friction, self._measured = friction, dict[str, float]()

    def __call__(self, report: FrameReport) -> float:
        """Return the margin after this frame."""
        load, name = report.load, report.array.name
        if not (report.array.shear and load.F > 0 and report.code.pressed):
            return math.nan
        ratio = math.hypot(load.Q, load.R) / load.F
        if ratio > 0 and any(event.kind == "slip" for event in report.events):
            self._measured[name] = ratio
        margin = 1 - ratio / self._measured.get(name, self._friction)
        return max(margin, 0.0) if margin == margin else margin


class StreamFrames:
    """Converts the reports of a run to `StreamFrame`; ``start_ns``: Unix time [ns] at which t is 0, None if unknown."""

    def __init__(self, start_ns: int | None = None, friction: float = FRICTION) -> None:
        self.start_ns, self._margins = start_ns, SlipMargins(friction)

    def __call__(self, report: FrameReport) -> StreamFrame:
        """Convert the next report."""
        frame = report.frame
        return StreamFrame(
            report.array.name,
            frame.t,
            math.nan if self.start_ns is None else self.start_ns * 1e-9 + frame.t,
            frame.t_device,
            frame.sequence,
            frame.values,
            frame.valid,
            report.load,
            report.code,
            self._margins(report),
            report.events,
            report.ended,
        )


FrameOutput = Callable[[StreamFrame, dict[str, Any]], None]
"""Takes a frame and its plain data without the values."""


class FrameSink:
    """A sink that passes each frame to ``outputs``; ``convert.start_ns`` is the Unix time at which t is 0."""

    def __init__(self, arrays: tuple[TaxelArray, ...], outputs: Iterable[FrameOutput]) -> None:
        self.convert = StreamFrames()
        self._events, self._outputs = EventData(arrays), tuple(outputs)

    def __call__(self, report: FrameReport) -> None:
        """Pass on one report."""
        if self._outputs:
            frame = self.convert(report)
            data = frame_data(frame, self._events)
            for output in self._outputs:
                output(frame, data)


def frame_data(frame: StreamFrame, events: EventData) -> dict[str, Any]:
    """Return a frame without its values as plain data for JSON; unknown numbers are None.

    ``events`` converts the events of the run.
    """
    begun, ended = [events(event) for event in frame.begun], [events.end(event) for event in frame.ended]
    return {
        "type": "frame", "t_s": frame.t, "unix_s": finite(frame.unix_s), "t_device_s": finite(frame.t_device),
        "finger": frame.finger, "sequence": frame.sequence, "load": load_data(frame.load),
        "centre_m": [finite(one) for one in frame.centre], "ternary": frame.code.ternary(),
        "slip_margin": finite(frame.slip_margin), "begun": begun, "ended": ended,
    }  # fmt: skip


def frame_json(frame: StreamFrame, data: dict[str, Any]) -> bytes:
    """Return a frame as a JSON object: its ``data`` and the values (rows, cols, 3), null where they are not valid.

    Values have the digits that give their bits as float32.
    """
    values = np.where(frame.valid[..., None], frame.values, np.nan).astype(np.float32)
    return orjson.dumps({**data, "values": values}, option=orjson.OPT_SERIALIZE_NUMPY)
