"""Bounds of what shakes contacts: random effects on fields, beside fixed ones that make contacts stiffer."""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from typing import Any

from cnnsim.support import InputError
from tactile.simulator.choice.extremes import Extremes
from tactile.simulator.choice.finger_bounds import SAFE
from tactile.simulator.choice.trials import Trial


def rises(
    on_fields: Sequence[tuple[str, Any]], on: Container[str], frames: int, but: Any = None
) -> tuple[tuple[float, float], ...]:
    """By how much [m] random effects that are on, ``but`` one, raise contacts at most, with the tip radius of each."""
    acting = [effect for name, effect in on_fields if effect is not but and "rises" in effect.SAYS and name in on]
    return tuple([(rise, effect.tip_radius) for effect in acting if (rise := effect.rises(frames)) > 0])


@dataclass
class Shaking:
    """What random ones of the effects ``on_fields`` may change, those named in ``on`` acting, on one finger.

    A contact on a layer is stiffer, and shakes its readings more, than on the half-space; all shakes grow with what
    fixed effects add to the readings. ``layered``: the cover is a layer.
    """

    on_fields: Sequence[tuple[str, Any]]
    on: Container[str]
    trial: Trial
    ideal: Extremes
    layered: bool

    def bounds(self, known: bool, grown: float, small: bool) -> dict[str, float]:
        """The bound of each.

        Arguments: ``known``: the fields with all effects are there for it; ``grown``: what fixed effects add to
        readings at most, by their own bounds; ``small``: whether one of these could be left out.
        """
        random = [one for one in self.on_fields if one[1].RANDOM]
        points, more = self.ideal.slopes.at_points, 1.0
        tips = points and self.layered
        fields = ["pressed" if tips else "shaken", "still"]
        if not known:
            by_law = not points and math.isinf(grown)
            if by_law and not small:  # nothing is to be gained
                return {name: math.inf for name, _ in random}
            fields = ["pressed" if by_law or tips else "shaken"]
            more = SAFE if by_law else 1.0
            more *= 1 + (self._as_points() if by_law else grown) / (self.ideal.seen.largest or 1.0)
        return {name: self._strays(effect, fields) * more for name, effect in random}

    def _strays(self, effect: Any, fields: Sequence[str]) -> float:
        """Bound of what one effect changes in the trial's fields of these names, which are made only when asked for."""
        frames = self.ideal.seen.frames
        if "strays" not in effect.SAYS:
            return math.inf
        others = rises(self.on_fields, self.on, frames, effect)
        slopes = self.ideal.slopes.raised(others) if others else self.ideal.slopes
        try:
            return max([float(effect.strays(getattr(self.trial, name), slopes, frames)) for name in fields])
        except InputError:  # raised so far, a contact goes through the cover
            return math.inf

    def _as_points(self) -> float:
        """Bound of what fixed effects that are on add to readings, as if all that presses did so at points."""
        at_points = replace(self.ideal.slopes, at_points=True)
        acting = [one for name, one in self.on_fields if name in self.on and not one.RANDOM]
        acting = [one for one in acting if not getattr(one, "smooths", False)]
        return sum(float(one.most(at_points)) if "most" in one.SAYS else math.inf for one in acting)
