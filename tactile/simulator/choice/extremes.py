"""Extremes of what the ideal taxels of a finger feel over a whole scene, and the frames in which they lie."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.simulator.choice.point_extremes import point_extremes, points_alone
from tactile.simulator.choice.scan import scan
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
    whole, slopes = None, None
    if len(pieces := list(scene.skin.pieces(finger))) == 1:
        whole = scene.skin.field(finger, pieces[0][1])
        if points_alone(whole):
            slopes = point_extremes(whole, peaks, where, ends)
    if slopes is None:
        near, fields = NearLoads(scene.skin.taxels(finger)), 0
        for field in [whole] if whole else scene.skin.fields(finger, pieces):
            values = np.ascontiguousarray(field.values).reshape(-1, channels)
            scan(values, field.first, last if fields else values[0], peaks, where, ends)
            near.add(field)
            last, fields = values[-1], fields + 1
        slopes = near.slopes(array, scene.skin.medium(finger), float(peaks.max()))
    low, high, change = ends.tolist()
    unit = scene.unit(finger)
    seen = Seen(array, unit, scene.full_scale * unit, scene.rate, scene.samples, slopes.largest, (low, high), change)
    if whole is not None:
        scene.skin.keep(finger, whole)
    return Extremes(seen, slopes, peaks, where, whole)
