"""Size and cost of effects, measured on a sample of a scene's frames."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support import Floats, Integers
from tactile.simulator.batch import Batch
from tactile.simulator.field import Field
from tactile.simulator.scene.effect_bounds import EffectBounds, Named
from tactile.simulator.scene.scene import Scene

TRIED = 64
"""Frames on which effects on fields are tried: each costs as much as the field, or many times that."""
FRAMES = 4096
"""Frames of each finger in a sample: the whole recording of all but long scenes."""


@dataclass(frozen=True)
class Sample:
    """Frames spread evenly over a scene, with what presses and what the ideal taxels feel: the base of estimates.

    ``most``: how many frames.
    """

    scene: Scene
    most: int = FRAMES
    _memory: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def numbers(self) -> Integers:
        """Which frames: all of a short scene, else evenly spread ones, the first and the last among them."""
        count = min(self.scene.samples, self.most)
        return np.unique(np.linspace(0, self.scene.samples - 1, count).round().astype(np.int64))

    @cached_property
    def fields(self) -> tuple[list[Field], ...]:
        """Every finger's fields, in the scene's own pieces, without effects."""
        skin = self.scene.skin
        return tuple(list(skin.fields(finger, self._pieces(finger))) for finger in range(len(skin.arrays)))

    def _pieces(self, finger: int) -> Iterator[tuple[int, Floats]]:
        longest = max(len(times) for _, times in self.scene.skin.pieces(finger))
        for start in range(0, len(self.numbers), longest):
            yield start, self.numbers[start : start + longest] / self.scene.rate

    @cached_property
    def peak(self) -> float:
        """The largest reading of the ideal skin; a share of the full scale where nothing presses."""
        largest = max((float(np.abs(one.values).max()) for fields in self.fields for one in fields), default=0.0)
        return largest if largest > 0 else max(self.scene.full_scale * self.scene.unit(0), np.finfo(float).tiny)

    def run(self, effects: Iterable[Named]) -> list[list[Batch]]:
        """The sample's frames of every finger through a chain of effects, ending with batches."""
        chosen, frames = list(effects), []
        for finger, fields in enumerate(self._affected([one for one in chosen if one[1].STAGE == "field"])):
            batches = [self._batch(finger, one) for one in fields]
            frames.append(list(self.scene.affected(batches, "frames", chosen, finger)))
        return frames

    def _affected(self, effects: list[Named]) -> list[list[Field]]:
        """The fields after effects on them, the last ones remembered: effects on frames are tried on the same."""
        kept = self._memory.get("fields")
        if kept is None or kept[0] != effects:
            fingers = range(len(self.scene.arrays))
            made = [list(self.scene.affected(self.fields[n], "field", effects, n)) for n in fingers]
            self._memory["fields"] = kept = effects, made
        found: list[list[Field]] = kept[1]
        return found

    def _batch(self, finger: int, given: Field) -> Batch:
        batch = self.scene.batch(finger, given)
        return replace(batch, values=batch.values.copy())

    def gap(self, one: list[list[Batch]], other: list[list[Batch]]) -> float:
        """Largest difference of two runs relative to the peak, each read at the sample's times.

        Between frames, and where frames are lost or late, a run is read by straight lines, as its user would.
        """
        times = self.numbers / self.scene.rate
        largest = 0.0
        for a, b in zip(one, other, strict=True):
            difference = np.abs(_read_at(a, times) - _read_at(b, times))
            largest = max(largest, float(difference.max(initial=0)))
        return largest / self.peak

    def seconds(self, effects: list[Named], repeat: int = 3) -> dict[str, float]:
        """Measured time per frame [s] of "contacts", "field" and every effect in its place in the chain.

        The best of some runs, each part's input made beforehand.
        """
        best: dict[str, float] = {}
        count = len(self.numbers) * len(self.scene.arrays)
        for _ in range(repeat):
            spent = dict.fromkeys(("contacts", "field", *(name for name, _ in effects)), 0.0)
            for finger in range(len(self.scene.arrays)):
                pieces = list(self._pieces(finger))
                begin = perf_counter()
                for _, times in pieces:
                    self.scene.skin.loads(finger, times)
                spent["contacts"] += perf_counter() - begin
                begin = perf_counter()
                stream: Any = list(self.scene.skin.fields(finger, pieces))
                before = _computed(stream)
                spent["field"] += perf_counter() - begin
                stage = "field"
                for name, effect in effects:
                    if stage != effect.STAGE:
                        stream, stage = [self._batch(finger, one) for one in stream], effect.STAGE
                    begin = perf_counter()
                    stream = list(effect(iter(stream), self.scene.random(name, finger)))
                    taken = perf_counter() - begin
                    if stage == "field":  # computed with all effects at once: what this one adds to it
                        after = _computed(stream)
                        taken, before = max(taken + after - before, 0.0), after
                    spent[name] += taken
            best = {name: min(best.get(name, np.inf), time / count) for name, time in spent.items()}
        best["field"] = max(best["field"] - best["contacts"], 0.0)  # fields ask for the contacts themselves
        return best


def _computed(fields: list[Field]) -> float:
    """Compute fields, and return how long it took [s]."""
    begin = perf_counter()
    for one in fields:
        _ = one.values
    return perf_counter() - begin


def _read_at(batches: list[Batch], times: Floats) -> Floats:
    t = np.concatenate([batch.t for batch in batches])
    values = np.concatenate([batch.values for batch in batches])
    if len(t) == len(times) and np.array_equal(t, times):
        return values
    t, first = np.unique(t, return_index=True)
    values = values[first]
    after = np.clip(np.searchsorted(t, times), 1, max(len(t) - 1, 1))
    if len(t) == 1:
        return np.broadcast_to(values, (len(times), *values.shape[1:]))
    share = np.clip((times - t[after - 1]) / (t[after] - t[after - 1]), 0, 1)[:, None, None, None]
    read: Floats = values[after - 1] * (1 - share) + values[after] * share
    return read


def sizes_in(scene: Scene, effects: Iterable[Named]) -> dict[str, float]:
    """Return the size of every effect in a scene, relative to the peak: the largest change of a reading.

    Of an effect of the scene: when it alone is taken away; of another: when it alone is added. What is fixed is
    measured, effects on fields on up to TRIED frames; what is random is a bound that all seeds but one in a thousand
    keep.
    """
    every, on = list(effects), dict(scene.effects)
    found = EffectBounds(scene, every, on)
    bounds = {name: size + found.steps_behind(name) * (size > 0) for name, size in found.sizes().items()}
    whole, few = Sample(scene), Sample(scene, TRIED)
    with_all, with_few = whole.run(scene.effects), few.run(scene.effects)
    sizes: dict[str, float] = {}
    for name, effect in every:
        if effect.RANDOM:
            sizes[name] = bounds[name]
            continue
        other = [(n, e) for n, e in every if (n in on) != (n == name)]
        if effect.STAGE == "field":
            sizes[name] = few.gap(few.run(other), with_few)
        else:
            sizes[name] = whole.gap(whole.run(other), with_all)
    return sizes
