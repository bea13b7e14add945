"""Table of windows of slides: the features of each, its slide, and its position in the slide."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from cnnsim.support.progress import watcher
from tactile.materials.features import FeatureSet
from tactile.materials.slide import Slide

GAP = 0.5
"""Largest gap in a window, as a part of its duration."""


@dataclass(frozen=True)
class WindowTable:
    """Windows (n,) of ``slides``: ``values`` (n, features), ``slide`` (n,) number of its slide.

    ``place`` (n,): 0 for the first window of its slide, 1 for one that ends with it; ``start`` (n,) its first sample;
    ``dropped``: number of windows without pressing or variation, or with a gap.
    """

    slides: Sequence[Slide]
    values: Floats
    slide: Integers
    place: Floats
    start: Integers
    dropped: int

    @property
    def material(self) -> "np.ndarray[tuple[int, ...], np.dtype[np.str_]]":
        """(n,) material of the slide of each window."""
        return np.array([one.material for one in self.slides])[self.slide]

    @property
    def block(self) -> Integers:
        """(n,) block of the slide of each window."""
        return np.array([one.block for one in self.slides])[self.slide]


def cut(slides: Sequence[Slide], features: FeatureSet, hop: int) -> WindowTable:
    """Cut slides into windows every ``hop`` samples, and compute their features.

    Raises:
        InputError: a hop below 1, or no usable window.
    """
    if hop < 1:
        raise InputError(f"windows every {hop} samples; 1 or more wanted")
    length, watch, rows, where, dropped = features.window, watcher(), [], [], 0
    for n, slide in enumerate(slides):
        if watch is not None:
            watch(n / len(slides), "features of windows")
        for start in range(0, slide.t.size - length + 1, hop):
            t = slide.t[start : start + length]
            row = features(t, slide.force[start : start + length], slide.speed)
            if not np.isfinite(row).all() or np.diff(t).max() > GAP * (t[-1] - t[0]):
                dropped += 1
                continue
            rows.append(row)
            where.append((n, start / max(slide.t.size - length, 1), start))
    if not rows:
        said = f"{len(slides)} slides without one window of {length} pressed samples"
        raise InputError(f"{said}; longer slides or a shorter window wanted")
    number, place, begin = zip(*where, strict=True)
    return WindowTable(slides, np.array(rows), np.array(number), np.array(place), np.array(begin), dropped)
