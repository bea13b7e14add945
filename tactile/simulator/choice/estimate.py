"""Size and cost of effects, measured on a sample of a scene's frames."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.simulator.batch import Batch
from tactile.simulator.choice.chain import Named
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.extremes import extremes
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene

FRAMES = 4096
"""Frames of each finger in a sample: the whole recording of all but long scenes."""
WIDTH = 8
"""Frames on each side of one that tells much, which a sample of a long scene has, too."""
DOUBT = 1.1
"""Where the steps of a converter may make a size so many times larger it is told as a bound."""


class Size(NamedTuple):
    """Size of an effect relative to the peak, as measured, or where it is ``at_most`` so large a bound."""

    change: float
    at_most: bool


@dataclass(frozen=True)
class Sample:
    """Frames spread evenly over a scene, with what presses and what the ideal taxels feel: the base of estimates.

    ``most``: how many frames; of a longer scene those around the ideal readings' peaks are among them.
    """

    scene: Scene
    most: int = FRAMES
    _memory: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def numbers(self) -> Integers:
        """Which frames: all of a short scene, else those near peaks and evenly spread ones, the first to the last."""
        every = np.arange(self.scene.samples)
        if len(every) <= self.most:
            return every
        times = np.concatenate([extremes(self.scene, n).times for n in range(len(self.scene.arrays))])
        near = np.add.outer(np.rint(times * self.scene.rate).astype(np.int64), np.arange(-WIDTH, WIDTH + 1))
        near = np.unique(near.clip(0, every[-1]))[: self.most // 2]
        others = np.setdiff1d(every, near)
        spread = np.linspace(0, len(others) - 1, self.most - len(near)).round().astype(np.int64)
        return np.union1d(near, others[spread])

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


def sizes_in(scene: Scene, effects: Iterable[Named]) -> dict[str, Size]:
    """Return the size of every effect in a scene, relative to the peak: the largest change of a reading.

    Of an effect of the scene: when it alone is taken away; of another: when it alone is added. What is fixed is
    measured with the scene's own seed, unless the steps of a converter behind it may make it larger: then it is a
    bound wherever the steps lie. What is random is a bound that all seeds but one in a million keep. Another effect
    that has no meaning in this scene, such as a stickiness that draws a needle too deep, is not among them.
    """
    every, on = list(effects), dict(scene.effects)
    found = EffectBounds(scene, every, on)
    bounds = {name: found.stepped(name, size) for name, size in found.sizes().items()}
    sample = Sample(scene)
    whole = _runs(sample, scene.effects, found.converters)
    sizes: dict[str, Size] = {}
    for name, effect in every:
        if effect.RANDOM:
            sizes[name] = Size(bounds[name], bounds[name] > 0)
            continue
        other = [(n, e) for n, e in every if (n in on) != (n == name)]
        steps = found.converters if found.stepped(name, 1.0) > 1 else ()
        try:
            runs = _runs(sample, other, steps)
        except InputError:
            if name in on:
                raise
            continue
        change, *smooth = map(sample.gap, runs, whole)
        most = found.stepped(name, max(smooth, default=change))
        sizes[name] = Size(max(most, change), True) if most > DOUBT * change else Size(change, False)
    return sizes


def _runs(sample: Sample, effects: Iterable[Named], converters: Collection[str]) -> list[list[list[Batch]]]:
    """A run of a chain; where it has converters also without these, and then without noise behind the field.

    Steps hide what is smaller than one, and noise says which readings lie near one.
    """
    chains = [list(effects)]
    if converters:
        smooth = [one for one in chains[0] if one[0] not in converters]
        chains += [smooth, [one for one in smooth if one[1].STAGE == "field" or not one[1].RANDOM]]
    return [sample.run(chain) for chain in chains]
