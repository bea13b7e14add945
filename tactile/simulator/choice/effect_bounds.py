"""Bounds of what effects change in a scene, each with the others on: by arithmetic, and by a trial on a few frames."""

import math
from collections.abc import Callable, Container, Iterable
from copy import copy
from dataclasses import replace
from functools import cached_property, partial, reduce
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.simulator.choice.chain import Chain, Named, asked
from tactile.simulator.choice.extremes import FOREMOST, Extremes, extremes
from tactile.simulator.choice.finger_bounds import FIELD, SAFE, FingerBounds, LeftOut, behind, largest
from tactile.simulator.choice.forces import highest_reading, unseen
from tactile.simulator.choice.shaking import Shaking, rises
from tactile.simulator.choice.trials import Trial, pays, pays_behind
from tactile.simulator.effect import sticks
from tactile.simulator.field import Field
from tactile.simulator.held_needle import Rises, pressed_by
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import RARE
from tactile.simulator.taxels import FINEST

SMALL, LARGE = 0.25, 5.0
"""Bounds of an effect, in tolerances, between which it is tried: most effects do a third of their bound."""
SURE = 2.0
"""What changes so many tolerances on the first frames tried stays: others could hardly make up for it."""
FAR = 2.0
"""Share of the peak from which bounds of all effects on fields together are too loose for what acts behind them."""
BEYOND = 1e6
"""Share of the peak at which a bound ends: it tells as little as one without an end, and is a number."""
COARSEST, PART = 1e-3, 0.05
"""Accuracy of the field at most, in trials and in a run, and the part of the tolerance that it may take."""


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
        self._scene, self._chain = scene, Chain(self.effects, on)
        self.zero, self.on_fields, self._on = self._chain.zero, self._chain.on_fields, self._chain.on

    @cached_property
    def _ideal(self) -> list[Extremes]:
        return [extremes(self._scene, finger, self._rises) for finger in range(len(self._scene.arrays))]

    @cached_property
    def _rises(self) -> Rises:
        return rises(self.on_fields, self._on, self._scene.samples)

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
        sticky = any(sticks(one) for name, one in self.on_fields if name in self._on and not one.RANDOM)
        return [
            Trial(ideal, partial(self.field, finger), self._chain.acted, self._rises, sticky)
            for finger, ideal in enumerate(self._ideal)
        ]

    def field(self, finger: int, times: Floats) -> Field:
        """The ideal field of a finger for a trial, as accurate, of the peak, where readings are raised far above it."""
        fine = max(self.rough / self._ideal[finger].growth, FINEST)
        return replace(self._scene.skin.field(finger, times), trial=True, accuracy=fine)

    @cached_property
    def rough(self) -> float:
        """How far the field may be off, of its peak, where it takes but a small part of the tolerance."""
        return max(self._scene.accuracy, min(self._tolerance * PART, COARSEST))

    @property
    def coarse(self) -> bool:
        """Whether a converter's steps are so coarse that it is on, and nothing before it may be left out.

        Often the forces say so before the field is computed.
        """
        converters = [effect for name, effect in self._chain.on_frames if name in self._on and hasattr(effect, "grain")]
        if not converters:
            return False
        highest = highest_reading(self._scene)
        seen = [unseen(self._scene, finger, highest) for finger in range(len(self._scene.arrays))]
        step = max(effect.grain(one) for effect in converters for one in seen)
        return step > 2 * self._tolerance * highest > 0 or step > 2 * self._tolerance * self.peak

    def sizes(self) -> dict[str, float]:
        """The bound of every effect relative to the peak."""
        fingers, peak, sizes = self.fingers, self.peak, dict.fromkeys([name for name, _ in self.effects], 0.0)
        for name in sizes:
            if name not in self.zero:
                sizes[name] = max([one.size(name) for one in fingers]) / peak
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
        nothing = [LeftOut() for _ in self.fingers]
        return self.largest(reduce(self.leave, [name for name in off if name not in self.zero], nothing))

    def leave(self, left: list[LeftOut], name: str) -> list[LeftOut]:
        """What is left out on every finger, with one effect more."""
        if len(left) == 1:
            return [self.fingers[0].without(left[0], name)]
        return [one.without(before, name) for one, before in zip(self.fingers, left, strict=True)]

    def largest(self, left: list[LeftOut]) -> float:
        """What leaving these out on every finger changes at most, relative to the peak."""
        return max([one.change(gone) for one, gone in zip(self.fingers, left, strict=True)]) / self.peak

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
        found, most, grown = FingerBounds(), 0.0, 0.0
        unsure = not self._tolerance or self._forces_change(ideal)
        slopes = ideal.slopes
        if self._rises:  # tips sink in deeper
            slopes = replace(slopes, hardest=pressed_by(slopes.hardest, slopes.medium, self._rises))
        for name, effect in self.on_fields:
            if effect.RANDOM:
                continue
            found.reach[name] = bound = np.inf if unsure else asked(effect, "most", np.inf, slopes)
            if name in self._on:
                most += bound
                grown += 0.0 if getattr(effect, "smooths", False) else bound
            if SMALL < bound / (self._tolerance * self.peak or 1.0) < LARGE or not math.isfinite(bound):
                self._try(name, effect, found, trial)
        if found.terms:
            found.whole = trial.every[1].values
        fixed, shaken = list(found.reach), self._shaken(found, trial, ideal, grown)
        for name in fixed:  # what they do grows with what presses
            found.reach[name] *= 1 + shaken / (ideal.seen.largest or 1.0)
        seen = ideal.seen
        too_loose = most > FAR * seen.largest and (
            self._reused or pays_behind(len(self._chain.on_frames), seen, trial.shaken, FOREMOST)
        )
        if found.terms or too_loose:
            seen = behind(seen, trial.still if found.terms else trial.first)
        else:
            seen = seen.after(min(most, BEYOND * seen.largest), False)
        seen = seen.after(min(shaken, BEYOND * seen.largest), True)
        found.reach[FIELD] = self.rough * seen.largest
        self._chain.bound_frames(found, seen)
        return found

    def _shaken(self, found: FingerBounds, trial: Trial, ideal: Extremes, grown: float) -> float:
        """Bound what random effects on fields change, and return what those that are on do together."""
        known = bool(found.terms) or self._reused or not self._tolerance
        small = any(reach <= self._tolerance * self.peak for reach in found.reach.values())
        bounds = Shaking(self.on_fields, self._on, trial, ideal).bounds(known, grown, small)
        found.reach.update(bounds)
        return math.hypot(*(reach for name, reach in bounds.items() if name in self._on))

    def _forces_change(self, ideal: Extremes) -> bool:
        """Whether bodies press otherwise with the effects on than on the ideal skin, from whose slopes bounds follow.

        A body that is pressed by depth does where another effect changes its law, one that sticks always.
        """
        if ideal.slopes.at_points:
            return False
        laws = [effect for name, effect in self.on_fields if name in self._on and not effect.RANDOM]
        if any(sticks(effect) for effect in laws):
            return True
        deep = any(getattr(contact, "given_depth", False) for contact in self._scene.contacts)
        return deep and any(not math.isfinite(asked(effect, "most", np.inf, ideal.slopes)) for effect in laws)

    @property
    def _layered(self) -> bool:
        return any(name == "finite_thickness" and name in self._on for name, _ in self.on_fields)

    def _try(self, name: str, effect: Any, found: FingerBounds, trial: Trial) -> None:
        """Find what a fixed effect on fields changes on the frames that tell most, where that may pay.

        Much on the first of them settles that it stays.
        """
        if self._tolerance:
            if not self._reused and not pays(
                effect, trial.shaken, self._scene.samples, trial.frames, len(found.terms) + 1, self._layered
            ):
                return
            if self.rough < FINEST * trial.growth:  # it could not tell
                return
            first = self._tried(name, effect, lambda: trial.few)
            most = math.inf if first is None else largest(first)
            if most > SURE * self._tolerance * self.peak:
                found.reach[name] = most * SAFE
                return
        change = self._tried(name, effect, lambda: trial.every)
        if change is not None:
            found.terms[name] = change
            del found.reach[name]

    def _tried(self, name: str, effect: Any, fields: Callable[[], tuple[Field, Field]]) -> Floats | None:
        """What an effect changes in a trial, None where contacts that are raised so far go through the cover."""
        try:
            return self._chain.change(name, effect, *fields())
        except InputError:
            return None
