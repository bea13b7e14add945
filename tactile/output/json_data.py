"""A run as plain data for JSON."""

from dataclasses import asdict
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.events.phases import Phase, phases
from tactile.inverse.validity import Validity
from tactile.output.collected import Collected
from tactile.output.event_data import EventData, program_data
from tactile.settings import Settings


def settings_data(settings: Settings) -> dict[str, Any]:
    """Return the settings of a run: tare, thresholds (None: default of the quantity), and the rest."""
    return {
        "tare": settings.tare, "sigmas": asdict(settings.sigmas),
        "shear": None if settings.shear is None else asdict(settings.shear),
        "contact": None if settings.contact is None else asdict(settings.contact),
        "window": settings.window, "floor": settings.floor, "programs": list(settings.programs),
        "backend": settings.backend,
    }  # fmt: skip


def finger_data(collected: Collected, arrays: tuple[TaxelArray, ...]) -> dict[str, dict[str, Any]]:
    """Return for each finger its frames, loads by validity, texture figures, phases and tare.

    The texture figures are medians over the frames where they are valid; None if there are none.
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
            "error": error_data(collected.errors(array.name)),
            "phases": [phase._asdict() for phase in _phases(collected, array.name)],
            "tare": None if (tare := collected.tare(array)) is None else tare.plain(),
        }
    return fingers


def run_data(collected: Collected, arrays: tuple[TaxelArray, ...], settings: Settings) -> dict[str, Any]:
    """Return a run: settings, fingers, events, changed outputs of users' programs, and tares."""
    told = EventData(arrays)
    return {
        "settings": settings_data(settings), "seconds": collected.seconds, "frames": collected.frames,
        "fingers": finger_data(collected, arrays),
        "events": [told(event) | {"latency_s": event.latency} for event in collected.events],
        "programs": [program_data(*row) for row in collected.outputs],
        "tares": [
            {"t_s": note.t, "finger": arrays[note.finger].name, "why": note.why, "detail": note.detail}
            for note in collected.notes if note.detail
        ],
    }  # fmt: skip


def _phases(collected: Collected, finger: str) -> list[Phase]:
    t = collected.columns(finger).t
    return phases(collected.events, finger, float(t[0]), float(t[-1])) if t.size else []


def error_data(errors: Floats) -> dict[str, Any] | None:
    """Return the errors of located loads against the true ones of a scene; None without any."""
    both = errors[np.isfinite(errors).all(axis=1)]
    if not len(both):
        return None
    place, force = both.T
    return {
        "frames": len(both), "place_median_m": float(np.median(place)), "place_max_m": float(place.max()),
        "force_median_n": float(np.median(force)), "force_max_n": float(force.max()),
    }  # fmt: skip


def _median(values: Floats) -> float | None:
    valid = values[np.isfinite(values)]
    return float(np.median(valid)) if valid.size else None
