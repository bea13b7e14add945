"""Extremes of what the ideal taxels of a finger feel over a whole scene, and the frames in which they lie."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, Integers
from cnnsim.support.compiling.kept_loops import kept_njit
from tactile.core.frame import NORMAL
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen
from tactile.simulator.slopes import NearLoads, Slopes

PEAKS, SPREAD, FOREMOST = 10, 3, 3
"""Frames on which effects on fields are tried: where readings have their peaks, and some evenly spread; the first."""


@dataclass(frozen=True)
class Extremes:
    """``seen``, ``slopes``: bounds of the ideal readings and of how fast they change from place to place.

    ``peaks``, ``where``: of every channel, with its frame; ``whole``: the field, where it is one piece.
    """

    seen: Seen
    slopes: Slopes
    peaks: Floats
    where: Integers
    whole: Field | None

    @cached_property
    def times(self) -> Floats:
        """Times [s] of the frames that tell most: those of the largest peaks, and a few evenly spread."""
        spread = np.linspace(0, self.seen.frames - 1, SPREAD).round().astype(np.int64)
        return np.unique(np.concatenate([self._telling, spread])) / self.seen.rate

    @cached_property
    def foremost(self) -> Floats:
        """Those of a few of them."""
        return np.sort(self._telling[:FOREMOST]) / self.seen.rate

    @cached_property
    def _telling(self) -> Integers:
        ranked = self.where[np.argsort(-self.peaks, kind="stable")].tolist()
        return np.array(list(dict.fromkeys(ranked))[:PEAKS], np.int64)


def extremes(scene: Scene, finger: int) -> Extremes:
    """Go once through all frames of a finger, without effects; a short scene keeps them for its run."""
    array = scene.arrays[finger]
    channels = array.rows * array.cols * 3
    peaks, where, ends, last = np.zeros(channels), np.zeros(channels, np.int64), np.zeros(3), np.empty(0)
    near, fields = NearLoads(scene.skin.taxels(finger)), 0
    for field in scene.skin.fields(finger, scene.skin.pieces(finger)):
        values = np.ascontiguousarray(field.values).reshape(-1, channels)
        _scan(values, field.first, last if fields else values[0], peaks, where, ends)
        near.add(field)
        last, fields = values[-1], fields + 1
    low, high, change = ends.tolist()
    unit, largest = scene.unit(finger), float(peaks.max())
    seen = Seen(array, unit, scene.full_scale * unit, scene.rate, scene.samples, largest, (low, high), change)
    whole = field if fields == 1 else None
    if whole is not None:
        scene.skin.keep(finger, whole)
    slopes = near.slopes(array, scene.skin.medium(finger), largest)
    return Extremes(seen, slopes, peaks, where, whole)


@kept_njit()
def _scan(values, first, last, peaks, where, ends):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Go on with every channel's peak and frame, and with the least and largest normal reading and largest step."""
    for n in range(values.shape[0]):
        for c in range(values.shape[1]):
            value = values[n, c]
            before = last[c] if n == 0 else values[n - 1, c]
            ends[2] = max(ends[2], abs(value - before))
            if abs(value) > peaks[c]:
                peaks[c], where[c] = abs(value), n + first
            if c % 3 == NORMAL:
                ends[0], ends[1] = min(ends[0], value), max(ends[1], value)
