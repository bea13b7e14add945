"""Bounds of what effects change in a scene, each with the others on: by arithmetic, and by a trial on a few frames."""

from collections.abc import Container, Iterable
from copy import copy
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.effect import is_off
from tactile.simulator.field import Field
from tactile.simulator.scene.extremes import Extremes, extremes
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene.trials import pays
from tactile.simulator.seen import RARE, Seen

Named = tuple[str, Any]
SAFE = 1.25
"""What is found on the frames that tell most may be so many times larger on another one."""
SMALL, LARGE = 0.25, 5.0
"""Bounds of an effect, in tolerances, between which it is tried: most effects do a third of their bound."""
SURE = 2.0
"""What changes so many tolerances on the first frames tried stays: others could hardly make up for it."""
FAR = 0.5
"""Share of the peak from which bounds of all effects on fields together are too loose for what acts behind them."""
COARSEST = 1e-3
"""Accuracy of trials at most: what effects change is a difference of two fields."""
_NOTHING = np.random.default_rng(0)
"""What is drawn by effects that draw nothing."""


@dataclass
class FingerBounds:
    """What the effects change in the readings of one finger, at most.

    ``terms``: name -> what a fixed effect on fields changes in the frames tried; ``reach``: name -> what any other
    effect changes at its place in the chain, those in ``normal`` adding up by their squares; ``growth``: name -> by
    what that may grow behind it; ``grains``: name -> what the smallest change before it may become, and the chance of
    that per unit of change.
    """

    terms: dict[str, Floats] = field(default_factory=dict)
    reach: dict[str, float] = field(default_factory=dict)
    normal: set[str] = field(default_factory=set)
    growth: dict[str, float] = field(default_factory=dict)
    grains: dict[str, tuple[float, float]] = field(default_factory=dict)
    whole: Floats = field(default_factory=lambda: np.zeros(1))

    def size(self, name: str) -> float:
        """What one effect changes."""
        reach = _largest(self.terms[name]) * SAFE if name in self.terms else self.reach[name]
        return reach * self.growth[name]

    def without(self, left: "LeftOut", name: str) -> "LeftOut":
        """The same with one more effect left out."""
        names, terms, growth, plain, squares = left
        if name in self.terms:
            terms, growth = terms + self.terms[name], max(growth, self.growth[name])
        elif name in self.normal:
            squares += (self.reach[name] * self.growth[name]) ** 2
        else:
            plain += self.reach[name] * self.growth[name]
        return LeftOut(names | {name}, terms, growth, plain, squares)

    def change(self, left: "LeftOut") -> float:
        """What leaving these out changes: the sum of what each does."""
        fixed = SAFE * _largest(left.terms) * left.growth if left.growth else 0.0
        total = fixed + left.plain + left.squares**0.5
        return total + sum(
            g for name, (g, chance) in self.grains.items() if name not in left.names and total * chance > RARE
        )


class LeftOut(NamedTuple):
    """Effects that are left out on one finger, and the sums of what they change: see ``FingerBounds``."""

    names: frozenset[str] = frozenset()
    terms: Floats = np.zeros(1)
    growth: float = 0.0
    plain: float = 0.0
    squares: float = 0.0


class EffectBounds:
    """Bounds for the effects of a chain, in the order in which they act, on every finger of a scene.

    ``on``: which of them act, all unless given; the others' bounds are those of adding one of them. ``peak``: the
    largest reading of the ideal skin; a share of the full scale where nothing presses. An effect that gives no bound of
    its own may change everything. With a ``tolerance`` fixed effects on fields are tried only where their own bound
    leaves open whether they matter, and no finer than it needs.
    """

    def __init__(
        self, scene: Scene, effects: Iterable[Named], on: Container[str] | None = None, tolerance: float = 0.0
    ) -> None:
        self.effects, self._tolerance = list(effects), tolerance
        self._on = {name for name, _ in self.effects if on is None or name in on}
        ideal = [extremes(scene, finger) for finger in range(len(scene.arrays))]
        self._samples = scene.samples
        largest = max(one.seen.largest for one in ideal)
        self.peak = largest or max(scene.full_scale * scene.unit(0), float(np.finfo(float).tiny))
        rough = max(scene.accuracy, min(tolerance / 30, COARSEST))
        self._fields, self._first = [
            [replace(scene.field(n, at), trial=True, accuracy=rough) for n, at in enumerate(times)]
            for times in ([one.times for one in ideal], [one.foremost for one in ideal])
        ]
        self.fingers = [self._bound(*one) for one in zip(self._fields, self._first, ideal, strict=True)]

    def sizes(self) -> dict[str, float]:
        """The bound of every effect relative to the peak."""
        return {name: max(one.size(name) for one in self.fingers) / self.peak for name, _ in self.effects}

    def change(self, off: Iterable[str]) -> float:
        """What leaving these out changes at most, relative to the peak."""
        nothing = [LeftOut() for _ in self.fingers]
        return self.largest(reduce(self.leave, off, nothing))

    def leave(self, left: list[LeftOut], name: str) -> list[LeftOut]:
        """What is left out on every finger, with one effect more."""
        return [one.without(before, name) for one, before in zip(self.fingers, left, strict=True)]

    def largest(self, left: list[LeftOut]) -> float:
        """What leaving these out on every finger changes at most, relative to the peak."""
        return max(one.change(gone) for one, gone in zip(self.fingers, left, strict=True)) / self.peak

    def without(self, off: Container[str]) -> "EffectBounds":
        """The same bounds, where what fixed effects on fields change is what those left out do together."""
        made = copy(self)
        made.fingers = []
        for given, old in zip(self._fields, self.fingers, strict=True):
            gone = [name for name in old.terms if name in off]
            if len(gone) > 1:  # the first of them stands for all
                terms = dict.fromkeys(gone[1:], np.zeros(1)) | {gone[0]: old.whole - self._acted(given, off).values}
                old = replace(old, terms=old.terms | terms)
            made.fingers.append(old)
        return made

    def bends(self, off: Container[str]) -> bool:
        """Whether several of these change loads or body, so that they may do more together than each alone."""
        return any(sum(name in off for name in one.terms) > 1 for one in self.fingers)

    def _acted(self, given: Field, off: Container[str]) -> Field:
        now = given
        for name, effect in self.effects:
            if effect.STAGE == "field" and not effect.RANDOM and name in self._on and name not in off:
                now = _after(effect, now)
        return now

    def _bound(self, given: Field, first: Field, ideal: Extremes) -> FingerBounds:
        found, shaken, most = FingerBounds(), 0.0, 0.0
        full, soon = self._acted(given, ()), self._acted(first, ())
        for name, effect in self.effects:
            if effect.STAGE != "field":
                continue
            if is_off(effect):
                found.reach[name] = 0.0
            elif effect.RANDOM:
                found.reach[name] = _asked(effect, "strays", np.inf, given, ideal.seen.frames)
                shaken = float(np.hypot(shaken, found.reach[name] if name in self._on else 0.0))
            else:
                bound = _asked(effect, "most", np.inf, given) if self._tolerance else np.inf
                most += bound if name in self._on else 0.0
                found.reach[name] = bound * ideal.seen.largest
                if SMALL < bound / (self._tolerance or 1.0) < LARGE or not np.isfinite(bound):
                    self._try(name, effect, found, (given, full), (first, soon))
        if found.terms:
            found.whole = full.values
        if found.terms or most > FAR:
            seen = _behind(ideal.seen, full if found.terms else soon)
        else:
            seen = ideal.seen.after(most * ideal.seen.largest, False)
        seen = seen.after(shaken, True)
        grows: dict[str, float] = {}
        for name, effect in self.effects:
            if effect.STAGE == "field":
                continue
            found.reach[name] = 0.0 if is_off(effect) else _asked(effect, "reach", np.inf, seen)
            if name in self._on and not is_off(effect):
                grows[name] = _asked(effect, "passes", 1.0, seen)
                grain = _asked(effect, "grain", 0.0, seen)
                if grain > 0:
                    found.grains[name] = grain, 3 * seen.taxels * seen.frames / grain
                behind = getattr(effect, "behind", None)
                seen = behind(seen) if behind else seen.after(min(found.reach[name], seen.largest), effect.RANDOM)
        growth = 1.0
        for name, effect in reversed(self.effects):
            found.growth[name] = growth
            growth *= grows.get(name, 1.0)
            if effect.NORMAL:
                found.normal.add(name)
        return found


    def _try(
        self, name: str, effect: Any, found: FingerBounds, every: tuple[Field, Field], few: tuple[Field, Field]
    ) -> None:
        """Find what a fixed effect on fields changes on the frames that tell most, where that may pay.

        Much on the first of them settles that it stays.
        """
        if not self._tolerance:
            found.terms[name] = self._change(name, effect, *every)
        elif pays(effect, few[0], self._samples, len(every[0].times)):
            change = _largest(self._change(name, effect, *few))
            if change > SURE * self._tolerance * self.peak:
                found.reach[name] = change * SAFE
            else:
                found.terms[name] = self._change(name, effect, *every)
        if name in found.terms:
            found.reach.pop(name)

    def _change(self, name: str, effect: Any, given: Field, full: Field) -> Floats:
        if name in self._on:
            return full.values - self._acted(given, {name}).values
        return _after(effect, full).values - full.values


def _asked(effect: Any, what: str, else_: float, *given: Any) -> float:
    ask = getattr(effect, what, None)
    return else_ if ask is None else float(ask(*given))


def _after(effect: Any, now: Field) -> Field:
    end: Field = next(effect(iter([now]), _NOTHING))
    return end


def _largest(values: Any) -> float:
    return float(np.abs(values).max(initial=0))


def _behind(seen: Seen, now: Field) -> Seen:
    """The bounds of the ideal field, behind effects on it, from the frames that tell most."""
    scale = SAFE * _largest(now.values) / seen.largest if seen.largest > 0 else 1.0
    low, high = seen.normal
    return replace(seen, largest=seen.largest * scale, normal=(low * scale, high * scale), change=seen.change * scale)
