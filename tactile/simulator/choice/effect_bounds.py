"""Bounds of what effects change in a scene, each with the others on: by arithmetic, and by a trial on a few frames."""

from collections.abc import Container, Iterable
from copy import copy
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.choice.chain import Chain, Named
from tactile.simulator.choice.extremes import Extremes, extremes
from tactile.simulator.choice.field_bounds import FieldBounds
from tactile.simulator.choice.finger_bounds import FIELD, FingerBounds, LeftOut
from tactile.simulator.choice.forces import highest_reading, unseen
from tactile.simulator.choice.shaking import rises
from tactile.simulator.choice.trials import Trial
from tactile.simulator.contacts.mounting import Rises
from tactile.simulator.effect import sticks
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import RARE
from tactile.simulator.taxels import FINEST

COARSEST, PART = 1e-3, 0.05
"""Accuracy of the field at most, in trials, and the part of the tolerance that it may take."""
ROUGHER = 5.0, 2.0
"""By what it may be rougher in a run where the tolerance has so much left."""


class EffectBounds:
    """Bounds for the effects of a chain, in the order in which they act, on every finger of a scene.

    ``on``: which of them act, all unless given; the others' bounds are those of adding one of them. An effect that
    gives no bound of its own may change everything. With a ``tolerance`` fixed effects on fields are tried only where
    their own bound leaves open whether they matter, and no finer than it needs; where ``reused`` all of these, else
    those for which it may pay in one run.
    """

    def __init__(
        self, scene: Scene, effects: Iterable[Named], on: Container[str] | None = None, tolerance: float = 0.0,
        reused: bool = False,
    ) -> None:  # fmt: skip
        self.effects, self._tolerance, self._reused = list(effects), tolerance, reused
        self._scene, self._named = scene, on

    @cached_property
    def _chain(self) -> Chain:
        return Chain(self.effects, self._named)

    @property
    def zero(self) -> set[str]:
        """Effects of strength zero."""
        return self._chain.zero

    @property
    def on_fields(self) -> list[Named]:
        """The others that act on fields."""
        return self._chain.on_fields

    @cached_property
    def _ideal(self) -> list[Extremes]:
        return [extremes(self._scene, finger, self._rises) for finger in range(len(self._scene.arrays))]

    @cached_property
    def _rises(self) -> Rises:
        return rises(self.on_fields, self._chain.on, self._scene.samples)

    @cached_property
    def peak(self) -> float:
        """The largest reading of the ideal skin; a share of the full scale where nothing presses."""
        highest = max(one.seen.largest for one in self._ideal)
        return highest or max(self._scene.full_scale * self._scene.unit(0), float(np.finfo(float).tiny))

    @cached_property
    def fingers(self) -> list[FingerBounds]:
        """Those of every finger, found when they are asked for."""
        return [self._bound(*both) for both in zip(self._trials, self._ideal, strict=True)]

    @cached_property
    def _trials(self) -> list[Trial]:
        sticky = any(sticks(one) for name, one in self.on_fields if name in self._chain.on and not one.RANDOM)
        return [
            Trial(ideal, partial(self.field, finger), self._chain.acted, self._rises, sticky)
            for finger, ideal in enumerate(self._ideal)
        ]

    def field(self, finger: int, times: Floats) -> Field:
        """The ideal field of a finger for a trial, as accurate, of the peak, where readings are raised far above it."""
        fine = max(self.rough / self._ideal[finger].growth, FINEST)
        return replace(self._scene.skin.field(finger, times), accuracy=fine)

    @cached_property
    def rough(self) -> float:
        """How far the field may be off, of its peak, where it takes but a small part of the tolerance."""
        return max(self._scene.accuracy, min(self._tolerance * PART, COARSEST))

    def rougher(self, joint: float) -> tuple[float, float]:
        """How far the field may be off where all that is left out, it among them, changes so much; and the bound then.

        It takes no more than half of what is left of the tolerance, and goes by steps, for tables are made for each.
        """
        growth = max([finger.reach[FIELD] for finger in self.fingers]) / self.peak
        for more in ROUGHER:
            if (change := growth * (more - 1)) <= (self._tolerance - joint) / 2:
                return self.rough * more, joint + change
        return self.rough, joint

    @property
    def on_frames(self) -> list[Named]:
        """Those that act on frames."""
        return self._chain.on_frames

    @cached_property
    def highest(self) -> float:
        """How large readings may be, as forces alone say."""
        return highest_reading(self._scene)

    @cached_property
    def step(self) -> float:
        """The largest step of the converters that are on, 0 without one."""
        step, chain, fingers = 0.0, self._chain, range(len(self._scene.arrays))
        for name, effect in chain.on_frames:
            if "grain" in effect.SAYS and name in chain.on:
                step = max(step, *[effect.grain(unseen(self._scene, finger, self.highest)) for finger in fingers])
        return step

    @property
    def coarse(self) -> bool:
        """Whether a converter's steps are so coarse that it is on, and nothing before it may be left out.

        Often the forces say so before the field is computed.
        """
        fine = 2 * self._tolerance
        return self.step > 0 and (self.step > fine * self.highest > 0 or self.step > fine * self.peak)

    def sizes(self) -> dict[str, float]:
        """The bound of every effect relative to the peak."""
        fingers, peak, sizes = self.fingers, self.peak, dict.fromkeys([name for name, _ in self.effects], 0.0)
        for finger in fingers:
            for name, size in finger.sizes().items():
                sizes[name] = max(sizes[name], size / peak) if name in sizes else size / peak
        sizes.pop(FIELD)
        return sizes

    @property
    def converters(self) -> set[str]:
        """Effects that are on which make steps."""
        return {name for one in self.fingers for name in one.grains}

    def stepped(self, name: str, change: float) -> float:
        """What a change that an effect makes becomes behind the converters after it, relative to the peak."""
        order = [one for one, _ in self.effects]
        after = set(order[order.index(name) + 1 :])
        steps = [
            sum(
                grain
                for one, (grain, chance) in finger.grains.items()
                if one in after and change * self.peak * chance > RARE
            )
            for finger in self.fingers
        ]
        return change + max(steps) / self.peak

    def change(self, off: Iterable[str]) -> float:
        """What leaving these out changes at most, relative to the peak."""
        most, out = 0.0, {name for name in off if name not in self.zero}
        for finger in self.fingers:
            left = LeftOut(finger)
            for name in out:
                left.add(name)
            most = max(most, left.change(out)[1])
        return most / self.peak

    def without(self, off: Container[str]) -> "EffectBounds":
        """The same bounds, where what fixed effects on fields change is what those left out do together."""
        made = copy(self)
        made.fingers = []
        for trial, old in zip(self._trials, self.fingers, strict=True):
            gone = [name for name in old.terms if name in off]
            if len(gone) > 1:  # the first of them stands for all
                terms = dict.fromkeys(gone[1:], np.zeros(1)) | {
                    gone[0]: old.whole - self._chain.acted(trial.every[0], off).values
                }
                old = replace(old, terms=old.terms | terms)
            made.fingers.append(old)
        return made

    def bends(self, off: Container[str]) -> bool:
        """Whether several of these change loads or body, so that they may do more together than each alone."""
        return any(sum(name in off for name in one.terms) > 1 for one in self.fingers)

    def _bound(self, trial: Trial, ideal: Extremes) -> FingerBounds:
        found, most = FingerBounds(), self._tolerance * self.peak
        deep = any(getattr(contact, "given_depth", False) for contact in self._scene.contacts)
        field = FieldBounds(self._chain, trial, ideal, self._rises, self.rough, most, self._reused, deep)
        self._chain.bound_frames(found, field.put_in(found))
        return found
