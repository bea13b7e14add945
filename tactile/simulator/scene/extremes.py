"""Extremes of what the ideal taxels of a finger feel over a whole scene, and the frames in which they lie."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.core.frame import NORMAL
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen

PEAKS, SPREAD, FOREMOST = 10, 3, 3
"""Frames on which effects on fields are tried: where readings have their peaks, and some evenly spread; the first."""


@dataclass(frozen=True)
class Extremes:
    """``seen``: bounds of the ideal readings; ``times`` [s] of the frames that tell most; ``foremost``: of a few."""

    seen: Seen
    times: Floats
    foremost: Floats


def extremes(scene: Scene, finger: int) -> Extremes:
    """Go once through all frames of a finger, without effects."""
    array, change, low, high = scene.arrays[finger], 0.0, 0.0, 0.0
    peaks, where, last = np.zeros(0), np.zeros(0, np.int64), np.zeros((0, 0))
    for field in scene.fields(finger, scene.pieces(finger)):
        values = field.values.reshape(len(field.times), -1)
        size = np.abs(values)
        at = size.argmax(axis=0)
        top = size[at, np.arange(size.shape[1])]
        if not peaks.size:
            peaks, where, last = np.zeros(size.shape[1]), np.zeros(size.shape[1], np.int64), values[:1]
        where = np.where(top > peaks, at + field.first, where)
        peaks = np.maximum(top, peaks)
        change = max(change, float(np.abs(np.diff(values, axis=0)).max(initial=0)), _largest(values[0] - last[-1]))
        normal, last = field.values[..., NORMAL], values[-1:]
        low, high = min(low, float(normal.min())), max(high, float(normal.max()))
    unit = scene.unit(finger)
    seen = Seen(array, unit, scene.full_scale * unit, scene.rate, scene.samples, _largest(peaks), (low, high), change)
    telling = _telling(peaks, where)
    spread = np.linspace(0, scene.samples - 1, SPREAD).round().astype(np.int64)
    every, few = np.unique(np.concatenate([telling, spread])), np.sort(telling[:FOREMOST])
    return Extremes(seen, every / scene.rate, few / scene.rate)


def _largest(values: Floats) -> float:
    return float(np.abs(values).max(initial=0))


def _telling(peaks: Floats, where: Integers) -> Integers:
    """The frames in which channels have their peaks, the largest first."""
    ranked = where[np.argsort(-peaks, kind="stable")]
    _, first = np.unique(ranked, return_index=True)
    return ranked[np.sort(first)][:PEAKS]
