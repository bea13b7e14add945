"""Frames of force pads from arrays of forces, and the events that the pipeline finds in a source."""

from typing import Any

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance, Source
from tactile.events.event import Event, EventLog
from tactile.pipeline import run
from tactile.settings import Settings

PAD = TaxelArray("pad", 6, 6, 3e-3, 0.0, quantity="force")


def stream(forces: np.ndarray, rate: float = 200.0, noise: float = 2e-3, seed: int = 1) -> FrameStream:
    """Return frames of forces (n, 6, 6, 3) [N] after 0.5 s without contact, with noise."""
    values = np.concatenate([np.zeros((round(rate / 2), *forces.shape[1:])), forces])
    values += noise * np.random.default_rng(seed).standard_normal(values.shape)
    return force_stream(np.arange(len(values)) / rate, values, PAD.pitch, untared=False)


def force_stream(t: np.ndarray, values: np.ndarray, pitch: float = 4e-3, *, untared: bool = True) -> FrameStream:
    """Return frames at times t (n,) [s] of forces (n, rows, cols, 3) [N] on one pad."""
    rows, cols = values.shape[1:3]
    pad = TaxelArray("pad", rows, cols, pitch, 0.0, quantity="force")
    frames = [Frame(0, time, n, values[n], np.ones((rows, cols), bool)) for n, time in enumerate(t.tolist())]
    return FrameStream("made", (pad,), None, len(frames), frames, Provenance(untared=untared))


def events(source: Source, **settings: Any) -> list[Event]:
    """Run the pipeline on a source and return its events, with their ends."""
    log = EventLog()
    run(source, Settings(**settings), [lambda report: log.add(report.events, report.ended)])
    return log.events


def patch(frames: int, rows: slice, cols: slice, force: tuple[float, float, float]) -> np.ndarray:
    """Return frames (n, 6, 6, 3) with one force on some taxels."""
    out = np.zeros((frames, 6, 6, 3))
    out[:, rows, cols] = force
    return out


def grip(frames: int = 200) -> np.ndarray:
    """Return frames (n, 6, 6, 3) with 0.5 N on each of the 4 x 4 middle taxels."""
    return patch(frames, slice(1, 5), slice(1, 5), (0.0, 0.0, 0.5))
