"""Bounds of what effects on the field of one finger change: by arithmetic, and by trials where they may pay."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cnnsim.support import Floats, InputError
from tactile.simulator.choice.chain import Chain, asked
from tactile.simulator.choice.extremes import FOREMOST, Extremes
from tactile.simulator.choice.finger_bounds import FIELD, SAFE, FingerBounds, behind, largest
from tactile.simulator.choice.shaking import Shaking
from tactile.simulator.choice.trials import FRAMES, Trial, pays, pays_behind
from tactile.simulator.contacts.mounting import Rises
from tactile.simulator.effect import sticks
from tactile.simulator.field import Field
from tactile.simulator.held_needle import pressed_by
from tactile.simulator.seen import Seen
from tactile.simulator.taxels import FINEST

SMALL, LARGE = 0.25, 5.0
"""Bounds of an effect, in tolerances, between which it is tried: most effects do a third of their bound."""
SURE = 2.0
"""What changes so many tolerances on the first frames tried stays: others could hardly make up for it."""
FAR = 2.0
"""Share of the peak from which bounds of all effects on fields together are too loose for what acts behind them."""
THICKNESS = "finite_thickness"
"""The effect that makes a layer of the cover."""
BEYOND = 1e6
"""Share of the peak at which a bound ends: it tells as little as one without an end, and is a number."""


@dataclass
class FieldBounds:
    """How the effects of a chain that act on the field of one finger are bound.

    ``rises``: by how much what shakes contacts raises them; ``rough``: how far the field may be off, of its peak;
    ``most``: the change that is allowed, 0 for none; ``reused``: everything in doubt is tried; ``deep``: a body is
    pressed by depth.
    """

    chain: Chain
    trial: Trial
    ideal: Extremes
    rises: Rises
    rough: float
    most: float
    reused: bool
    deep: bool

    def put_in(self, found: FingerBounds) -> Seen:
        """Put the bounds in, and return what is known of the readings behind all that are on."""
        chain, seen = self.chain, self.ideal.seen
        together, grown = self._fixed(found)
        if found.terms:
            found.whole = self.trial.every[1].values
        fixed, shaken = list(found.reach), self._shaken(found, grown)
        if shaken:
            for name in fixed:  # what they do grows with what presses
                found.reach[name] *= 1 + shaken / (seen.largest or 1.0)
            if THICKNESS in found.reach:  # on the half-space contacts are held less stiffly
                found.reach[THICKNESS] += shaken
        too_loose = together > FAR * seen.largest and (
            self.reused
            or (seen.frames >= FRAMES and pays_behind(len(chain.on_frames), seen, self.trial.shaken, FOREMOST))
        )
        if found.terms or too_loose:
            seen = behind(seen, self.trial.still if found.terms else self.trial.first)
        else:
            seen = seen.after(min(together, BEYOND * seen.largest), False)
        seen = seen.after(min(shaken, BEYOND * seen.largest), True)
        # the peak of which the field is off: what smooths it makes no larger one
        found.reach[FIELD] = self.rough * min(seen.largest, self.ideal.seen.largest + grown + shaken)
        return seen

    def _fixed(self, found: FingerBounds) -> tuple[float, float]:
        """Bound what fixed effects change; return what those that are on do together, and what they add."""
        together = grown = 0.0
        unsure, slopes = not self.most or self._forces_change(), self.ideal.slopes
        if self.rises:  # tips sink in deeper
            medium = self.trial.pressed.medium if slopes.at_points and self._layered else slopes.medium
            slopes = slopes.pressed(pressed_by(slopes.hardest, medium, self.rises))
        for name, effect in self.chain.on_fields:
            if effect.RANDOM:
                continue
            found.reach[name] = bound = math.inf if unsure else asked(effect, "most", math.inf, slopes)
            if name in self.chain.on:
                together += bound
                grown += 0.0 if getattr(effect, "smooths", False) else bound
            if SMALL < bound / (self.most or 1.0) < LARGE or not math.isfinite(bound):
                self._try(name, effect, found)
        return together, grown

    def _shaken(self, found: FingerBounds, grown: float) -> float:
        """Bound what random effects change, and return what those that are on do together."""
        if not any(effect.RANDOM for _, effect in self.chain.on_fields):
            return 0.0
        known = bool(found.terms) or self.reused or not self.most
        small = any(reach <= self.most for reach in found.reach.values())
        bounds = Shaking(self.chain.on_fields, self.chain.on, self.trial, self.ideal, self._layered).bounds(
            known, grown, small
        )
        found.reach.update(bounds)
        return math.hypot(*[reach for name, reach in bounds.items() if name in self.chain.on])

    def _forces_change(self) -> bool:
        """Whether bodies press otherwise with the effects on than on the ideal skin, from whose slopes bounds follow.

        A body that is pressed by depth does where another effect changes its law, one that sticks always.
        """
        slopes = self.ideal.slopes
        if slopes.at_points:
            return False
        laws = [effect for name, effect in self.chain.on_fields if name in self.chain.on and not effect.RANDOM]
        if any(sticks(effect) for effect in laws):
            return True
        return self.deep and any(not math.isfinite(asked(effect, "most", math.inf, slopes)) for effect in laws)

    def _try(self, name: str, effect: Any, found: FingerBounds) -> None:
        """Find what a fixed effect changes on the frames that tell most, where that may pay.

        Much on the first of them settles that it stays.
        """
        trial, frames = self.trial, self.ideal.seen.frames
        if self.most:
            if not self.reused and (
                frames < FRAMES
                or not pays(effect, trial.shaken, frames, trial.frames, len(found.terms) + 1, self._layered)
            ):
                found.untried.add(name)
                return
            if self.rough < FINEST * trial.growth:  # it could not tell
                return
            first = self._tried(name, effect, lambda: trial.few)
            most = math.inf if first is None else largest(first)
            if most > SURE * self.most:
                found.reach[name] = most * SAFE
                return
        change = self._tried(name, effect, lambda: trial.every)
        if change is not None:
            found.terms[name] = change
            del found.reach[name]

    @property
    def _layered(self) -> bool:
        return THICKNESS in self.chain.on

    def _tried(self, name: str, effect: Any, fields: Callable[[], tuple[Field, Field]]) -> Floats | None:
        """What an effect changes in a trial, None where contacts that are raised so far go through the cover."""
        try:
            return self.chain.change(name, effect, *fields())
        except InputError:
            return None
