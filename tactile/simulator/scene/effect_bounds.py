"""Bounds of what effects change in a scene, each with the others on: by arithmetic, and by a trial on a few frames."""

from collections.abc import Container, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.effect import is_off
from tactile.simulator.field import Field
from tactile.simulator.scene.extremes import Extremes, extremes
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import RARE, Seen

Named = tuple[str, Any]
SAFE = 1.25
"""What is found on the frames that tell most may be so many times larger on another one."""


@dataclass
class FingerBounds:
    """What the effects change in the readings of one finger, at most.

    ``terms``: name -> what a fixed effect on fields adds in the frames tried; ``reach``: name -> what any other
    effect changes at its place in the chain, those in ``normal`` adding up by their squares; ``growth``: name -> by
    what that may grow behind it; ``grains``: name -> what the smallest change before it may become, and the chance of
    that per unit of change.
    """

    terms: dict[str, Floats] = field(default_factory=dict)
    reach: dict[str, float] = field(default_factory=dict)
    normal: set[str] = field(default_factory=set)
    growth: dict[str, float] = field(default_factory=dict)
    grains: dict[str, tuple[float, float]] = field(default_factory=dict)

    def size(self, name: str) -> float:
        """What one effect changes."""
        reach = _largest(self.terms[name]) * SAFE if name in self.terms else self.reach[name]
        return reach * self.growth[name]

    def change(self, off: Iterable[str]) -> float:
        """What leaving these out changes: the sum of what each does."""
        left = set(off)
        fixed = [name for name in left if name in self.terms]
        total = SAFE * _largest(sum(self.terms[name] for name in fixed)) * self.growth[fixed[0]] if fixed else 0.0
        rest = [(self.reach[name] * self.growth[name], name in self.normal) for name in left if name in self.reach]
        total += sum(size for size, normal in rest if not normal)
        total += sum(size**2 for size, normal in rest if normal) ** 0.5
        return total + sum(g for name, (g, chance) in self.grains.items() if name not in left and total * chance > RARE)


class EffectBounds:
    """Bounds for the effects of a chain, in the order in which they act, on every finger of a scene.

    ``on``: which of them act, all unless given; the others' bounds are those of adding one of them. ``peak``: the
    largest reading of the ideal skin; a share of the full scale where nothing presses. An effect that gives no bound of
    its own may change everything.
    """

    def __init__(self, scene: Scene, effects: Iterable[Named], on: Container[str] | None = None) -> None:
        self.effects = list(effects)
        self._on = {name for name, _ in self.effects if on is None or name in on}
        ideal = [extremes(scene, finger) for finger in range(len(scene.arrays))]
        largest = max(one.seen.largest for one in ideal)
        self.peak = largest or max(scene.full_scale * scene.unit(0), float(np.finfo(float).tiny))
        self._fields = [next(scene.fields(n, [(0, one.times)])) for n, one in enumerate(ideal)]
        self.fingers = [self._bound(*both) for both in zip(self._fields, ideal, strict=True)]

    def sizes(self) -> dict[str, float]:
        """The bound of every effect relative to the peak."""
        return {name: max(one.size(name) for one in self.fingers) / self.peak for name, _ in self.effects}

    def change(self, off: Iterable[str]) -> float:
        """What leaving these out changes at most, relative to the peak."""
        return max(one.change(off) for one in self.fingers) / self.peak

    def without(self, off: Container[str]) -> "EffectBounds":
        """The same bounds, where what fixed effects on fields add is that without those left out."""
        made = object.__new__(EffectBounds)
        made.effects, made.peak, made._on, made._fields = self.effects, self.peak, self._on, self._fields
        made.fingers = []
        for given, old in zip(self._fields, self.fingers, strict=True):
            now = given
            for name, effect in self.effects:
                if name in old.terms and name not in off:
                    now = _acted(effect, now)
            whole = sum(old.terms.values()) + _values(given)
            # the first of them stands for all
            gone = [name for name in old.terms if name in off]
            terms = dict.fromkeys(gone[1:], np.zeros(1)) | {gone[0]: whole - _values(now)}
            made.fingers.append(replace(old, terms=old.terms | terms))
        return made

    def bends(self, off: Container[str]) -> bool:
        """Whether one of these changes loads or body, and with it what other effects on fields add."""
        return any(name in self._bending and name in off for name, _ in self.effects)

    def _bound(self, given: Field, ideal: Extremes) -> FingerBounds:
        found, now, shaken = FingerBounds(), given, 0.0
        felt = _values(given)
        self._bending: set[str] = set()
        for name, effect in self.effects:
            if effect.STAGE == "field" and effect.RANDOM:
                found.reach[name] = 0.0 if is_off(effect) else _asked(effect, "strays", np.inf, now, ideal.seen.frames)
                shaken = float(np.hypot(shaken, found.reach[name] if name in self._on else 0.0))
            elif effect.STAGE == "field":
                changed = _acted(effect, now)
                found.terms[name] = np.zeros(1)
                if changed is not now:  # fields are computed with all effects at once
                    self._bending.add(name)
                    values = _values(changed)
                    found.terms[name] = values - felt
                    now, felt = (changed, values) if name in self._on else (now, felt)
        seen = (ideal.seen if now is given else _behind(ideal.seen, given, now)).after(shaken, True)
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


def _asked(effect: Any, what: str, else_: float, *given: Any) -> float:
    ask = getattr(effect, what, None)
    return else_ if ask is None else float(ask(*given))


def _acted(effect: Any, now: Field) -> Field:
    end: Field = next(effect(iter([now]), np.random.default_rng(0)))  # fixed: it draws nothing
    return end


def _values(now: Field) -> Floats:
    """What the taxels feel in the frames tried.

    On the half-space by quadrature, since a table for a few frames does not pay; one for the layer is made anyway.
    """
    return replace(now, accuracy=0.0).values if np.isinf(now.medium.thickness) else now.values


def _largest(values: Any) -> float:
    return float(np.abs(values).max(initial=0))


def _behind(seen: Seen, ideal: Field, now: Field) -> Seen:
    """The bounds of the ideal field, behind effects on it, from the frames that tell most."""
    before, after = _largest(ideal.values), _largest(now.values)
    scale = SAFE * after / before if before > 0 else 1.0
    low, high = seen.normal
    return replace(seen, largest=seen.largest * scale, normal=(low * scale, high * scale), change=seen.change * scale)
