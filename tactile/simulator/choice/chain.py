"""The effects of a scene in the order in which they act, which of them are on, and fields behind them."""

import math
from collections.abc import Container, Sequence
from typing import Any

from cnnsim.support import Floats
from tactile.simulator.choice.finger_bounds import FIELD, FingerBounds
from tactile.simulator.field import Field
from tactile.simulator.scene.scene import NOTHING
from tactile.simulator.seen import Seen

Named = tuple[str, Any]


class Chain:
    """Effects in their order; ``names`` are on, all unless given.

    ``zero``: those of strength zero; ``on_fields`` and ``on_frames``: the others, by what they act on; ``on``: which of
    these are on.
    """

    def __init__(self, effects: Sequence[Named], names: Container[str] | None) -> None:
        self.zero: set[str] = set()
        self.on: set[str] = set()
        self.on_fields: list[Named] = []
        self.on_frames: list[Named] = []
        for one in effects:
            name, effect = one
            if effect.off:
                self.zero.add(name)
                continue
            (self.on_fields if effect.STAGE == "field" else self.on_frames).append(one)
            if names is None or name in names:
                self.on.add(name)

    def acted(self, given: Field, off: Container[str] = ()) -> Field:
        """A field behind the fixed effects that act on it, but for those left out."""
        now = given
        for name, effect in self.on_fields:
            if not effect.RANDOM and name in self.on and name not in off:
                now = _after(effect, now)
        return now

    def change(self, name: str, effect: Any, given: Field, full: Field) -> Floats:
        """What an effect changes, from the ideal field and the ``full`` one behind all that are on."""
        if name in self.on:
            return full.values - self.acted(given, {name}).values
        return _after(effect, full).values - full.values

    def bound_frames(self, found: FingerBounds, seen: Seen) -> None:
        """Bound effects on frames, given bounds of the readings before the first of them, and what grows behind all."""
        reaches, growth, grown = found.reach, 1.0, []
        for name, effect in self.on_frames:
            says = effect.SAYS
            reach = effect.reach(seen) if "reach" in says else math.inf
            passes = 1.0
            if effect.NORMAL:
                found.normal.add(name)
            if name in self.on:
                if "passes" in says:
                    passes = effect.passes(seen)
                if "grain" in says and (grain := effect.grain(seen)) > 0:
                    found.grains[name] = grain, 3 * seen.taxels * seen.frames / grain
                if "behind" in says:
                    seen = effect.behind(seen)
                else:  # noise may be larger than the readings
                    seen = seen.after(reach if reach < math.inf else seen.largest, effect.RANDOM)
            grown.append((name, reach, passes))
        for name, reach, passes in reversed(grown):
            reaches[name] = reach * growth
            growth *= passes
        found.growth = growth
        for name, effect in self.on_fields:
            if effect.NORMAL:
                found.normal.add(name)
            if name in reaches:
                reaches[name] *= growth
        reaches[FIELD] *= growth


def asked(effect: Any, what: str, else_: float, *given: Any) -> float:
    """Return what an effect answers, or another number where it has no such answer."""
    ask = getattr(effect, what, None)
    return else_ if ask is None else float(ask(*given))


def _after(effect: Any, now: Field) -> Field:
    end: Field = next(effect(iter([now]), NOTHING))
    return end
