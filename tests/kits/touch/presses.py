"""Recordings of two force pads that are pressed, with an offset, for exports."""

from pathlib import Path

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.sources.replay_npz import write_npz

START = 1_700_000_000_123_456_789
"""[ns] Unix time of the first sample."""
PADS = (
    TaxelArray("thumb", 2, 2, 0.004, 0.0, quantity="force"), TaxelArray("palm", 1, 3, 0.004, 0.0, quantity="force"),
)  # fmt: skip


def presses(rate: float = 137.0, seconds: float = 2.0, seed: int = 0) -> FrameStream:
    """Return frames of both pads: idle, pressed with 0.4 N a taxel from 1 s to 1.5 s, idle; offsets of 2 N."""
    rng, frames = np.random.default_rng(seed), []
    for n in range(round(rate * seconds)):
        for finger, pad in enumerate(PADS):
            t = (n + 0.3 * finger) / rate
            values = 2 + rng.normal(0, [0.001, 0.001, 0.003], (*pad.shape, 3))
            values[..., 2] += 0.4 * (1 <= t < 1.5)
            frames.append(Frame(finger, t, n, values, np.ones(pad.shape, bool)))
    return FrameStream("two presses", PADS, None, len(frames), frames, Provenance(untared=True, start_ns=START))


def write_presses(path: Path, rate: float = 137.0, seconds: float = 2.0, seed: int = 0) -> Path:
    """Write them to an NPZ file and return its path."""
    write_npz(path, presses(rate, seconds, seed))
    return path
