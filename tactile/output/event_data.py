"""Events as plain data for JSON; for large arrays only the changes of the code."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.load import Load

INLINE = 64
"""Largest number of taxels whose whole code is in every event."""


class EventData:
    """Converts the events of a run, in order, to plain data.

    An array of more than `INLINE` taxels has ``changed`` in place of ``arrows`` and ``ternary``: the numbers of the
    ``taxels`` (row * cols + col) whose code differs from that of the finger's previous event, and their ``ternary``
    codes; before the first event all are 00. A hand with more taxels has no ``hand``.
    """

    def __init__(self, arrays: tuple[TaxelArray, ...]) -> None:
        self._sizes = {array.name: array.rows * array.cols for array in arrays}
        self._hand = sum(self._sizes.values()) <= INLINE
        self._before: dict[str, Any] = {}

    def __call__(self, event: Event) -> dict[str, Any]:
        """Convert the next event."""
        data = event_data(event)
        if not self._hand:
            del data["hand"]
        if self._sizes.get(event.finger, 0) > INLINE:
            del data["arrows"], data["ternary"]
            data["changed"] = self._changed(event)
        return data

    def end(self, event: Event) -> dict[str, Any]:
        """Return the new data of an ended event: its end, and data added at the end."""
        whole = event_data(event)
        return {name: whole[name] for name in ("t_s", "end_s", "finger", "kind", "data", "words")}

    def _changed(self, event: Event) -> dict[str, Any]:
        code = np.frombuffer(event.ternary.encode(), "S2")
        before = self._before.get(event.finger, np.full_like(code, b"00"))
        self._before[event.finger] = code
        taxels = np.flatnonzero(code != before)
        return {"taxels": taxels.tolist(), "ternary": code[taxels].tobytes().decode()}


def event_data(event: Event) -> dict[str, Any]:
    """Return the data of an event that follow from the frames, without its latency."""
    data = {name: finite(value) if isinstance(value, float) else value for name, value in event.data.items()}
    return {
        "t_s": event.t, "end_s": event.end, "told_s": finite(event.told), "finger": event.finger,
        "sequence": event.sequence, "kind": event.kind, "data": data, "taxels": event.taxels,
        "confidence": event.confidence, "words": event.words,
        "arrows": event.arrows, "ternary": event.ternary, "hand": f"{event.hand:x}",
        "load": load_data(event.load),
    }  # fmt: skip


def program_data(t: float, finger: str, program: str, outputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the output of a user's program for a frame: logic as 0 and 1, analog numbers to six digits."""
    plain = {}
    for output, value in outputs.items():
        values = np.asarray(value)
        if values.dtype.kind in "bi":
            plain[output] = values.astype(int).tolist()
        else:
            known = np.array(np.round(values, 6), dtype=object)
            known[~np.isfinite(values)] = None
            plain[output] = known.tolist()
    return {"t_s": t, "finger": finger, "program": program, "outputs": plain}


def load_data(load: Load | None) -> dict[str, Any] | None:
    """Return a located load with its uncertainty, None without one."""
    if load is None or not math.isfinite(load.F):
        return None
    where: dict[str, Any] = {name: finite(getattr(load, name)) for name in ("x", "y", "Q", "R", "F")}
    where |= {"sigma": [finite(one) for one in load.sigma], "misfit": finite(load.misfit), "taxels": load.taxels}
    where |= {"left_out": load.left_out, "saturated": load.saturated}
    where |= {"others": [load_data(other) for other in load.others]}
    return where | {"validity": load.validity.name.lower()}


def finite(value: float | None) -> float | None:
    """Return a number for JSON: None for NaN and infinity."""
    return value if value is not None and math.isfinite(value) else None
