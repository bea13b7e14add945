"""Size and time of every effect of a scene, measured on a sample of its frames."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.simulator.auto_effects import bounds, readings, step_of
from tactile.simulator.batch import Batch
from tactile.simulator.effects import ORDER, effect_class
from tactile.simulator.field import Field
from tactile.simulator.scene.extremes import hardest_times
from tactile.simulator.scene.hardest_frames import FEW
from tactile.simulator.scene.scene import Scene

Named = tuple[str, Any]
FRAMES = 4096
"""Frames of each finger in a sample: the whole recording of all but long scenes."""
WIDTH = 8
"""Frames on each side of a hardest frame that are in the sample of a long scene."""
SEEDS = 3
"""Seeds over which a random effect without a bound is measured."""
STEPS = 0.1
"""Step of a converter, over the size of an effect, above which the step is added to the size."""


class Size(NamedTuple):
    """Size of an effect relative to the peak: the measured ``change``, or an upper bound where it is ``at_most``."""

    change: float
    at_most: bool


@dataclass(frozen=True)
class Sample:
    """Frames of a scene on which chains of effects are compared.

    ``most``: how many; of a longer scene those around the hardest frames and evenly spread ones.
    """

    scene: Scene
    most: int = FRAMES

    @cached_property
    def numbers(self) -> Integers:
        """Numbers of the frames: all of a short scene; else hardest and evenly spread ones, first and last included."""
        every = np.arange(self.scene.samples)
        if len(every) <= self.most:
            return every
        times = np.concatenate([hardest_times(self.scene, n, FEW) for n in range(len(self.scene.arrays))])
        near = np.add.outer(np.rint(times * self.scene.rate).astype(np.int64), np.arange(-WIDTH, WIDTH + 1))
        near = np.unique(near.clip(0, every[-1]))[: self.most // 2]
        others = np.setdiff1d(every, near)
        spread = np.linspace(0, len(others) - 1, self.most - len(near)).round().astype(np.int64)
        return np.union1d(near, others[spread])

    @cached_property
    def fields(self) -> tuple[list[Field], ...]:
        """The fields of every finger without effects, in chunks as the scene computes them."""
        skin = self.scene.skin
        return tuple(list(skin.fields(finger, self._chunks(finger))) for finger in range(len(skin.arrays)))

    def _chunks(self, finger: int) -> Iterator[tuple[int, Floats]]:
        longest = max(len(times) for _, times in self.scene.skin.chunks(finger))
        for start in range(0, len(self.numbers), longest):
            yield start, self.numbers[start : start + longest] / self.scene.rate

    @cached_property
    def peak(self) -> float:
        """The largest reading of the ideal skin; full scale where nothing presses."""
        largest = max((float(np.abs(one.values).max()) for fields in self.fields for one in fields), default=0.0)
        return largest or self.scene.full_scale * self.scene.unit(0)

    def run(self, effects: Iterable[Named], seed: int | None = None) -> list[list[Batch]]:
        """The frames of every finger with a chain of effects, drawn from a seed or that of the scene."""
        chosen, frames = list(effects), []
        scene = self.scene if seed is None else replace(self.scene, seed=seed)
        on_fields = [one for one in chosen if one[1].STAGE == "field"]
        if self._last.get("chain") != (on_fields, seed):
            fields = [list(scene.affected(one, "field", on_fields, n)) for n, one in enumerate(self.fields)]
            self._last.update(chain=(on_fields, seed), fields=fields)
        for finger, made in enumerate(self._last["fields"]):
            batches = (_batch(scene, finger, one) for one in made)
            frames.append(list(scene.affected(batches, "frames", chosen, finger)))
        return frames

    @cached_property
    def _last(self) -> dict[str, Any]:
        """The last chain of effects on fields, with its fields."""
        return {}

    def gap(self, one: list[list[Batch]], other: list[list[Batch]]) -> float:
        """Largest difference of two runs relative to the peak, both interpolated linearly at the sample's times."""
        times = self.numbers / self.scene.rate
        largest = 0.0
        for a, b in zip(one, other, strict=True):
            largest = max(largest, float(np.abs(_read_at(a, times) - _read_at(b, times)).max(initial=0)))
        return largest / self.peak

    def seconds(self, effects: list[Named], repeat: int = 3) -> dict[str, float]:
        """Measured time per frame [s] of "contacts", "field" and every effect of a chain: the best of some runs."""
        best: dict[str, float] = {}
        count = len(self.numbers) * len(self.scene.arrays)
        for _ in range(repeat):
            spent = dict.fromkeys(("contacts", "field", *(name for name, _ in effects)), 0.0)
            for finger in range(len(self.scene.arrays)):
                begin = perf_counter()
                stream: Any = list(self.scene.skin.fields(finger, self._chunks(finger)))
                for one in stream:
                    _ = one.loads
                spent["contacts"] += perf_counter() - begin
                before = _time_of_values(stream)
                spent["field"] += before
                stage = "field"
                for name, effect in effects:
                    if stage != effect.STAGE:
                        stream, stage = [_batch(self.scene, finger, one) for one in stream], effect.STAGE
                    begin = perf_counter()
                    stream = list(effect(iter(stream), self.scene.random(name, finger)))
                    taken = perf_counter() - begin
                    if stage == "field":  # computed with all effects at once: the time that this one adds
                        after = _time_of_values(stream)
                        taken, before = max(taken + after - before, 0.0), after
                    spent[name] += taken
            best = {name: min(best.get(name, np.inf), time / count) for name, time in spent.items()}
        return best


def _batch(scene: Scene, finger: int, given: Field) -> Batch:
    batch = scene.batch(finger, given)
    return replace(batch, values=batch.values.copy())


def _time_of_values(fields: list[Field]) -> float:
    """Compute fields and return the time [s]."""
    begin = perf_counter()
    for one in fields:
        _ = one.values
    return perf_counter() - begin


def _read_at(batches: list[Batch], times: Floats) -> Floats:
    t = np.concatenate([batch.t for batch in batches])
    values = np.concatenate([batch.values for batch in batches]).reshape(len(t), -1)
    if len(t) == len(times) and np.array_equal(t, times):
        return values
    t, first = np.unique(t, return_index=True)
    return np.stack([np.interp(times, t, channel) for channel in values[first].T], axis=1)


def every_effect(scene: Scene) -> list[Named]:
    """All effects: those of the scene, else at typical strength; with bumps only effects on frames."""
    named = dict(scene.effects)
    every = [(name, named[name] if name in named else effect_class(name)()) for name in ORDER]
    return [one for one in every if scene.bumps is None or one[1].STAGE == "frames"]


def sizes_in(scene: Scene, effects: Iterable[Named], sample: Sample | None = None) -> dict[str, Size]:
    """Return the size of effects in a scene: the largest change of a reading, relative to the peak of the ideal skin.

    For an effect of the scene: when it alone is removed; for another: when it alone is added. A fixed effect is
    measured, without a converter, whose step is added where it is not small: then the size is an upper bound. A random
    effect has its upper bound; without one it is measured with three seeds. Effects that cannot be computed in this
    scene, such as an adhesion that draws a needle in too deep, are left out.
    """
    sample, on, sizes = sample or Sample(scene), dict(scene.effects), dict[str, Size]()
    bases: dict[Any, list[list[Batch]]] = {}

    def change(name: str, effect: Any, converter: bool, seed: int | None) -> float:
        base = [one for one in scene.effects if converter or one[0] != "quantisation"]
        key = converter, seed
        if key not in bases:
            bases[key] = sample.run(base, seed)
        others = [one for one in base if one[0] != name]
        chain = others if name in on else sorted([*others, (name, effect)], key=lambda one: ORDER.index(one[0]))
        return sample.gap(bases[key], sample.run(chain, seed))

    bases[True, None] = sample.run(scene.effects)
    largest = max(float(np.abs(batch.values).max(initial=0)) for finger in bases[True, None] for batch in finger)
    effects = list(effects)
    most = bounds(dict(effects), readings(scene, largest))
    step = step_of(scene) / sample.peak
    for name, effect in effects:
        stepped = step * (ORDER.index(name) < ORDER.index("quantisation"))
        if effect.RANDOM and name in most:
            size = most[name] / sample.peak
            sizes[name] = Size(size + stepped * (size > 0), size > 0)
            continue
        seeds = [None, *range(1, SEEDS)] if effect.RANDOM else [None]
        try:
            size = max(change(name, effect, not stepped, seed) for seed in seeds)
        except InputError:
            if name in on:
                raise
            continue
        rough = stepped > STEPS * size > 0
        sizes[name] = Size(size + stepped * rough, rough)
    return sizes
