"""Labelled sequences of a simulated magnetometer board, and its array description."""

from pathlib import Path
from typing import Any

import numpy as np

BOARD = """
protocol = "reskin"
[[finger]]
name = "tip"
rows = 3
cols = 3
pitch_mm = 7.0
depth_mm = 0.0
quantity = "force"
cells = [[-1, 1, -1], [4, 0, 2], [-1, 3, -1]]
"""
RATE, START = 100.0, 120


def write_sequences(folder: Path, **changed: np.ndarray) -> tuple[Path, Path]:
    """Write four sequences with 5 uT noise, two with a ramp of 4 uT per frame from 1.2 s on; return file and array."""
    rng, slips = np.random.default_rng(0), np.array([True, False, True, False])
    signal = 300 + 5 * rng.standard_normal((4, 250, 15))
    ramp = 4.0 * np.maximum(np.arange(250) - START, 0)
    signal[slips, :, 0::3] += ramp[None, :, None]
    arrays: dict[str, Any] = {"signal": signal.astype(np.float32), "slip": slips, "rate_hz": np.array(RATE)} | changed
    np.savez(folder / "slips.npz", **arrays)
    (folder / "board.toml").write_text(BOARD, encoding="utf-8")
    return folder / "slips.npz", folder / "board.toml"
