"""Events and runs as plain data for JSON: in files, in recordings and on standard output alike."""

import math
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected


def event_data(event: Event) -> dict[str, Any]:
    """Return an event: all that follows from the frames, so not its latency."""
    data = {name: finite(value) if isinstance(value, float) else value for name, value in event.data.items()}
    return {
        "t_s": event.t, "finger": event.finger, "sequence": event.sequence, "kind": event.kind.label, "data": data,
        "words": event.words, "arrows": event.arrows, "ternary": event.ternary, "hand": f"{event.hand:x}",
        "load": load_data(event.load),
    }  # fmt: skip


def load_data(load: Load | None) -> dict[str, Any] | None:
    """Return a located load with how sure it is, None where there is none."""
    if load is None or not math.isfinite(load.F):
        return None
    where: dict[str, Any] = {name: finite(getattr(load, name)) for name in ("x", "y", "Q", "R", "F")}
    where |= {"sigma": [finite(one) for one in load.sigma], "misfit": load.misfit, "taxels": load.taxels}
    where |= {"left_out": load.left_out, "others": [load_data(other) for other in load.others]}
    return where | {"validity": load.validity.name.lower()}


def run_data(collected: Collected, arrays: tuple[TaxelArray, ...]) -> dict[str, Any]:
    """Return a run: events, and for each finger its frames, loads by validity, texture figures and tare.

    The texture figures are medians over the frames in which they were valid; None if they never were.
    """
    fingers = {}
    for array in arrays:
        columns = collected.columns(array.name)
        kinds = {kind.name.lower(): int((columns.validity == kind).sum()) for kind in Validity}
        fingers[array.name] = {
            "frames": columns.t.size,
            "located": {kind: count for kind, count in kinds.items() if count},
            "friction": _median(columns.friction),
            "roughness": _median(columns.roughness),
            "tare": None if (tare := collected.tare(array)) is None else tare.plain(),
        }
    events = [event_data(event) | {"latency_s": event.latency} for event in collected.events]
    return {"seconds": collected.seconds, "frames": collected.frames, "fingers": fingers, "events": events}


def finite(value: float | None) -> float | None:
    """Return a number as JSON has it: None for NaN and infinity."""
    return value if value is not None and math.isfinite(value) else None


def _median(values: Floats) -> float | None:
    valid = values[np.isfinite(values)]
    return float(np.median(valid)) if valid.size else None
