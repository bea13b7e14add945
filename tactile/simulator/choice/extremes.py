"""Extremes of what the ideal taxels of a finger feel over a whole scene, and the frames in which they lie."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.simulator.choice.point_extremes import point_extremes, points_alone
from tactile.simulator.choice.scan import scan
from tactile.simulator.contacts.mounting import Rises
from tactile.simulator.field import Field
from tactile.simulator.held_needle import grown
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen
from tactile.simulator.slopes import NearLoads, Slopes

PEAKS, SPREAD, FOREMOST = 10, 3, 3
"""Frames on which effects on fields are tried: where readings have their peaks, and some evenly spread; the first."""
RAISED = 4
"""The same where what shakes contacts raises readings highest, and by most: under light contacts."""


@dataclass
class Extremes:
    """``seen``, ``slopes``: bounds of the ideal readings and of how fast they change from place to place.

    ``peaks``, ``where``: of every channel, with its frame; ``whole``: the field of a short scene; ``rises``: by how
    much what shakes contacts raises them at most; ``raised``: the peaks there of a long one.
    """

    seen: Seen
    slopes: Slopes
    peaks: Floats
    where: Integers
    whole: Field | None
    rises: Rises
    raised: "RaisedPeaks | None"

    @cached_property
    def times(self) -> Floats:
        """Times [s] of the frames that tell most: those of the largest peaks, also raised, and a few evenly spread."""
        spread = np.linspace(0, self.seen.frames - 1, SPREAD).round().astype(np.int64)
        return np.unique(np.concatenate([self._telling, self._light, spread])) / self.seen.rate

    @cached_property
    def foremost(self) -> Floats:
        """Those of a few of them."""
        return np.unique(np.concatenate([self._telling[:FOREMOST], self._light[:1], self._light[-1:]])) / self.seen.rate

    @cached_property
    def _telling(self) -> Integers:
        return _foremost(self.peaks, self.where, PEAKS)

    @cached_property
    def growth(self) -> float:
        """By what the largest reading grows at most where contacts are raised."""
        return max(float(self._raised.peaks[0].max(initial=0)) / (self.seen.largest or 1.0), 1.0)

    @cached_property
    def _light(self) -> Integers:
        both = zip(self._raised.peaks, self._raised.where, strict=True)
        return np.concatenate([_foremost(peaks, where, RAISED) for peaks, where in both])

    @cached_property
    def _raised(self) -> "RaisedPeaks":
        if self.raised is not None:
            return self.raised
        raised = RaisedPeaks(self.rises, len(self.peaks))
        if self.whole is not None:
            raised.add(self.whole)
        return raised


class RaisedPeaks:
    """Every channel's largest reading, and largest rise of one, with its frame, as what shakes contacts may raise them.

    ``peaks``, ``where`` (2, channels).
    """

    def __init__(self, rises: Rises, channels: int) -> None:
        self._rises = rises
        self.peaks, self.where = np.zeros((2, 2, channels if rises else 0))

    def add(self, field: Field) -> None:
        """Count the frames of a field without effects."""
        if not self._rises:
            return
        values, growth = np.abs(field.values.reshape(len(field.times), -1)), grown(field, self._rises)[:, None]
        for n, raised in enumerate((values * growth, values * (growth - 1))):
            most, at = raised.max(axis=0), raised.argmax(axis=0) + field.first
            higher = most > self.peaks[n]
            self.peaks[n, higher], self.where[n, higher] = most[higher], at[higher]


def _foremost(peaks: Floats, where: Any, most: int) -> Integers:
    """Frames of the largest peaks, each once, the largest first."""
    ranked = where[np.argsort(-peaks, kind="stable")].tolist()
    return np.array(list(dict.fromkeys(ranked))[:most], np.int64)


def extremes(scene: Scene, finger: int, rises: Rises = ()) -> Extremes:
    """Go once through all frames of a finger, without effects; a short scene keeps them for its run.

    Arguments: ``rises``: by how much what shakes contacts raises them at most.
    """
    array, skin = scene.arrays[finger], scene.skin
    channels = array.rows * array.cols * 3
    peaks, where, ends = np.zeros(channels), np.zeros(channels, np.int64), np.zeros(3)
    whole, raised = skin.field(finger, np.arange(scene.samples) / scene.rate), None
    kept: Field | None = whole
    if points_alone(whole):
        slopes = point_extremes(whole, peaks, where, ends)
    else:
        pieces = list(skin.pieces(finger))
        near, last = NearLoads(skin.taxels(finger)), np.empty(0)
        if len(pieces) > 1:
            kept, raised = None, RaisedPeaks(rises, channels)
        for field in [whole] if kept else skin.fields(finger, pieces):
            values = np.ascontiguousarray(field.values).reshape(-1, channels)
            scan(values, field.first, last if field.first else values[0], peaks, where, ends)
            near.add(field)
            if raised:
                raised.add(field)
            last = values[-1]
        slopes = near.slopes(array, skin.medium(finger), float(peaks.max()))
    low, high, change = ends.tolist()
    unit = scene.unit(finger)
    seen = Seen(array, unit, scene.full_scale * unit, scene.rate, scene.samples, slopes.largest, (low, high), change)
    if kept is not None:
        skin.keep(finger, kept)
    return Extremes(seen, slopes, peaks, where, kept, rises, raised)
