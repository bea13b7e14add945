"""Automatic choice of effects by size: ``effects = "auto"`` keeps what matters in a scene and says what it left out."""

from collections.abc import Container
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import COLUMNS, F
from tactile.simulator.choice.chain import Named
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.finger_bounds import FIELD
from tactile.simulator.choice.forces import sinks_in
from tactile.simulator.choice.leaving import negligible
from tactile.simulator.choice.prospects import may_pay, points_may_pay
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.effect import is_off
from tactile.simulator.effects import ORDER, Effect, effect_class
from tactile.simulator.scene.scene import Scene
from tactile.simulator.summation import ACCURACY

MOMENTS = 64
"""Frames on which it is tried whether typical effects have a meaning where no keyframes tell the hardest one."""


@dataclass(frozen=True)
class Choice:
    """What the automatic choice decided.

    ``scene`` with the chosen effects; ``off``: those that it leaves out; ``bound``: of the error against everything on;
    ``tried``: False where choosing would have cost more than it may save, and all is on.
    """

    scene: Scene
    tolerance: float
    off: frozenset[str]
    bound: float
    bounds: EffectBounds
    tried: bool

    @cached_property
    def sizes(self) -> dict[str, float]:
        """Bound of what every effect changes with the others on, relative to the peak."""
        return self.bounds.sizes()

    @property
    def left_out(self) -> dict[str, float]:
        """Those of the effects that are off."""
        return {name: size for name, size in self.sizes.items() if name in self.off}

    @property
    def together(self) -> tuple[str, ...]:
        """Effects smaller than the tolerance that are on because with them what is left out would exceed it."""
        return tuple(name for name, size in self.sizes.items() if name not in self.off and size <= self.tolerance)

    @property
    def untried(self) -> tuple[str, ...]:
        """Effects that are on because only a trial could tell that they are small: it costs more than it may save.

        None before steps so coarse that it would tell nothing.
        """
        if self.bounds.coarse:
            return ()
        doubted = {name for finger in self.bounds.fingers for name in finger.untried}
        return tuple(name for name in self.sizes if name in doubted and name not in (*self.off, *self.together))


def candidates(scene: Scene) -> list[Named]:
    """Every effect there is: as the scene describes it, or typical; on bumps not those of a flat cover.

    Nor a typical one with which this scene has no meaning, such as a cover thinner than a contact sinks in.
    """
    named = dict(scene.effects)
    return _meaningful(scene, [(name, named.get(name, typical)) for name, typical in _typical()], named)


def all_effects(scene: Scene) -> list[Named]:
    """The effects of a scene whose effects are all on: those that it describes, and what every skin has, typical."""
    named = dict(scene.effects)
    return _meaningful(
        scene,
        [(name, named.get(name, typical)) for name, typical in _typical() if name in named or typical.ASSUMED],
        named,
    )


@cache
def _typical() -> list[tuple[str, Any]]:
    return [(name, effect_class(name)()) for name in ORDER]


def _meaningful(scene: Scene, effects: list[Named], named: Container[str]) -> list[Named]:
    if scene.bumps is not None:
        effects = [(name, effect) for name, effect in effects if effect.STAGE != "field"]
    if not scene.contacts:
        return effects
    guessed = [one for one in effects if one[0] not in named and one[1].STAGE == "field" and not one[1].RANDOM]
    if _has_meaning(scene, guessed):  # which holds nearly always
        return effects
    absurd = {one[0] for one in guessed if not _has_meaning(scene, [one])}
    return [one for one in effects if one[0] not in absurd]


def _has_meaning(scene: Scene, more: list[Named]) -> bool:
    order = {name: n for n, name in enumerate(ORDER)}
    if _sink_little(scene, dict([*scene.effects, *more])):
        return True
    whole = scene.with_effects(sorted([*scene.effects, *more], key=lambda one: order[one[0]]))
    try:
        for finger in range(len(scene.arrays)):
            whole.loads_at(finger, _hardest_moments(scene, finger))
    except InputError:
        return False
    return True


def _sink_little(scene: Scene, effects: dict[str, Effect]) -> bool:
    """Whether no contact may go through the cover or be as wide as a needle, as its push and the half-space say."""
    acting = {name: effect for name, effect in effects.items() if not is_off(effect)}
    sticks: Any = acting.get("adhesion")
    dome: Any = acting.get("curved_fingertip")
    rig = Rig(work=sticks.work if sticks else 0.0, curvature=1 / dome.radius if dome else 0.0)
    cover: Any = acting.get("finite_thickness")
    thickness = [cover.thickness or 2 * array.depth if cover else np.inf for array in scene.arrays]
    bulk: Any = acting.get("poisson_ratio")
    media = [scene.skin.medium(finger) for finger in range(len(scene.arrays))]
    media = [replace(one, nu=bulk.nu) for one in media] if bulk else media  # the softer for it
    return all(
        sinks_in(one, media[one.finger], deep := thickness[one.finger], rig) < 0.9 * min(deep, _tip(one))
        for one in scene.contacts
    )


def _tip(contact: Any) -> float:
    """Radius of a needle [m], infinite of what has none: its contact on a layer must stay narrower than itself."""
    body = getattr(contact, "indenter", None)
    return body.radius if body is not None and body.shape == "needle" else np.inf


def _hardest_moments(scene: Scene, finger: int) -> Floats:
    """Times [s] at which what presses does so hardest: of each body one, and some where there are no keyframes."""
    last, times = (scene.samples - 1) / scene.rate, [np.zeros(1)]
    for contact in scene.contacts:
        if contact.finger != finger:
            continue
        path = getattr(contact, "path", None)
        if path is None or path.shape[1] <= COLUMNS:  # a map's strength, which tells no force
            times.append(np.linspace(0, last, min(scene.samples, MOMENTS)))
        else:  # pushes change linearly between keyframes and the end
            keys = np.clip(path[:, 0], 0, last)
            times.append(keys[np.interp(keys, path[:, 0], path[:, 1 + F]).argmax()][None])
    return np.unique(np.concatenate(times))


def choose(scene: Scene, tolerance: float, reused: bool = False) -> Choice:
    """Leave out the effects that together change no reading by more than the tolerance times the peak.

    Candidates are the effects that the scene describes, and at typical strength those that every skin has. Bounds
    hold over the whole recording, and what is random for all seeds but one in a million. Effects on fields,
    which cost most, are left out first, each time the smallest; what those left out do together is then tried on the
    frames with the largest readings. Where choosing would cost more than it may save in one run all stays on, unless
    the choice is ``reused``. For one run the field, too, is computed only as finely as the tolerance asks, unless the
    scene says another accuracy than the usual one.

    Raises:
        InputError: a tolerance that is not positive.
    """
    if not tolerance > 0:
        raise InputError(f"tolerance {tolerance}, a positive number wanted")
    effects = all_effects(scene)
    bounds = EffectBounds(scene, effects, tolerance=tolerance, reused=reused)
    off, joint = {name for name, effect in effects if effect.off}, 0.0
    points = scene.bumps is None and not scene.contacts
    tried = reused or (points_may_pay(scene, bounds, tolerance) if points else may_pay(scene, effects, tolerance))
    if tried and not bounds.coarse:
        # the effects of a reused choice are kept, not how finely they were computed
        rough = not reused and scene.accuracy == ACCURACY < bounds.rough and scene.bumps is None
        off, joint = negligible(bounds, tolerance, rough)
    accuracy = None
    if FIELD in off:
        off.remove(FIELD)
        accuracy, joint = bounds.rougher(joint)
    chosen = scene.with_effects([one for one in effects if one[0] not in off], accuracy)
    return Choice(chosen, tolerance, frozenset(off), joint, bounds, tried)
