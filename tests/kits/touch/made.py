"""Frames of a force pad, made from forces, and the events that the pipeline finds in a source."""

from typing import Any

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Source
from tactile.events.event import Event, EventLog
from tactile.pipeline import run
from tactile.settings import Settings

PAD = TaxelArray("pad", 6, 6, 3e-3, 0.0, quantity="force")


def stream(forces: np.ndarray, rate: float = 200.0, noise: float = 2e-3, seed: int = 1) -> FrameStream:
    """Frames (n, 6, 6, 3) after half a second of nothing, with noise."""
    quiet = np.zeros((round(rate / 2), *forces.shape[1:]))
    values = np.concatenate([quiet, forces]) + noise * np.random.default_rng(seed).standard_normal(
        (len(quiet) + len(forces), *forces.shape[1:])
    )
    frames = [Frame(0, n / rate, n, one, np.ones(PAD.shape, bool)) for n, one in enumerate(values)]
    return FrameStream("made", (PAD,), None, len(frames), frames)


def events(source: Source, **settings: Any) -> list[Event]:
    log = EventLog()
    run(source, Settings(**settings), [lambda report: log.add(report.events, report.ended)])
    return log.events


def patch(frames: int, rows: slice, cols: slice, force: tuple[float, float, float]) -> np.ndarray:
    out = np.zeros((frames, 6, 6, 3))
    out[:, rows, cols] = force
    return out


def grip(frames: int = 200) -> np.ndarray:
    return patch(frames, slice(1, 5), slice(1, 5), (0.0, 0.0, 0.5))
