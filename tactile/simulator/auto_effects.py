"""Automatic choice of effects: which effects of a scene ``effects = "auto"`` drops, and how accurate the field is.

The error against all effects of the scene at the usual accuracy is the sum of three parts, at most the tolerance: the
field's own error, an upper bound for every dropped effect, and one step of a converter.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.scene.checks import COARSEST
from tactile.simulator.scene.extremes import hardest_times, key_times
from tactile.simulator.scene.scene import Scene
from tactile.simulator.summation import ACCURACY

FIELD_SHARE = 1 / 3
"""Share of the tolerance for the error of the field."""
RARE = 1e-6
"""Probability that a random effect exceeds its bound."""
SAFE = 1.25
"""Factor on changes and readings that were computed on a few frames only."""
AMPLIFIED = 2.0
"""Factor on the ideal readings that effects on fields are assumed not to exceed."""
LONG = 1000
"""Frames of a finger from which effects on fields are dropped by evaluation."""
HARDEST = 8
"""Frames on which the peak, and effects on fields, are evaluated: those with the hardest loads."""
EVALUATED = ("taxel_area", "finite_tip", "cover_error", "misplacement", "curved_fingertip")
"""Effects that are dropped by evaluation, the slowest first."""


class Readings(NamedTuple):
    """Arguments of bounds: ``largest`` reading, ``full_scale``, number of ``taxels`` and ``frames``, ``rate`` [Hz]."""

    largest: float
    full_scale: float
    taxels: int
    frames: int
    rate: float

    @property
    def duration(self) -> float:
        """From the first frame to the last [s]."""
        return (self.frames - 1) / self.rate

    def deviations(self, count: int) -> float:
        """The largest of ``count`` standard normal numbers, exceeded with probability ``RARE``."""
        return NormalDist().inv_cdf(1 - RARE / (2 * max(count, 1)))


def _crosstalk(effect: Any, on: Readings) -> float:
    across = 2 * abs(effect.cross_axis)
    return on.largest * (across + (1 + across) * 4 * abs(effect.neighbour))


def _dead(effect: Any, on: Readings) -> float:
    if (effect.dead + effect.stuck) * on.taxels < RARE:
        return 0.0
    return on.largest + on.full_scale * (effect.stuck > 0)


def _drift(effect: Any, on: Readings) -> float:
    # a walk exceeds a level before its end twice as often as at its end
    spread = math.sqrt((effect.rate * on.duration) ** 2 + effect.walk**2 * on.duration)
    return on.full_scale * spread * on.deviations(2 * 3 * on.taxels)


def _mismatch(effect: Any, on: Readings) -> float:
    most = on.deviations(6 * on.taxels)
    gain, ratio = most * effect.gain, most * effect.beta_ns
    return on.largest * (gain + ratio + gain * ratio) + most * effect.offset * on.full_scale


def _noise(effect: Any, on: Readings) -> float:
    return float(effect.rms * on.full_scale * on.deviations(3 * on.taxels * on.frames))


def _temperature(effect: Any, on: Readings) -> float:
    warm = max(abs(effect.start), abs(effect.start - effect.change * math.expm1(-on.duration / effect.time)))
    return warm * (abs(effect.gain) * on.largest + abs(effect.offset) * on.full_scale)


def _viscoelastic(effect: Any, on: Readings) -> float:
    return sum(g * -math.expm1(-on.duration / tau) for g, tau in effect.parts) * on.largest


BOUNDS: dict[str, Callable[[Any, Readings], float]] = {
    "pink_noise": _noise,
    "drift": _drift,
    "read_noise": _noise,
    "crosstalk": _crosstalk,
    "hysteresis": lambda effect, on: effect.weight * min(5 / 8 * effect.width * on.full_scale, on.largest),
    "motor_noise": lambda effect, on: effect.amplitude * on.full_scale * (effect.duty > 0),
    "temperature": _temperature,
    "taxel_mismatch": _mismatch,
    "viscoelastic": _viscoelastic,
    "dead_taxels": _dead,
}
"""Upper bound of the change of any reading by an effect; by a random one, for all seeds but one in a million.

The slowest effects first."""


@dataclass(frozen=True)
class Choice:
    """A choice of effects.

    ``scene`` with the chosen effects and accuracy; ``left_out``: bounds of the dropped effects, and ``bound`` of the
    whole error, relative to the peak.
    """

    scene: Scene
    tolerance: float
    left_out: dict[str, float]
    bound: float


def choose(scene: Scene, tolerance: float, reused: bool = False) -> Choice:
    """Return the scene with a coarser field and without the effects that do not matter.

    No reading changes by more than the tolerance times the peak of the ideal skin. The field gets a third of the
    tolerance, unless the scene states another accuracy than the usual one. Effects are dropped by their bounds, the
    slowest first, and effects on fields, in scenes of ``LONG`` frames or where the choice is ``reused``, by evaluation
    on the frames with the hardest loads. Where the step of a converter exceeds the rest, nothing changes.

    Raises:
        InputError: a tolerance that is not positive.
    """
    if not tolerance > 0:
        raise InputError(f"tolerance {tolerance}, a positive number wanted")
    effects = {name: effect for name, effect in scene.effects if not effect.off}
    accuracy, error = scene.accuracy, 0.0
    if scene.accuracy == ACCURACY < FIELD_SHARE * tolerance and scene.bumps is None:
        accuracy = error = min(FIELD_SHARE * tolerance, COARSEST)
    evaluated = [name for name in EVALUATED if name in effects and (reused or scene.samples >= LONG)]
    left_out: dict[str, float] = {}
    if evaluated or "quantisation" in effects or effects.keys() & BOUNDS.keys():
        if any(isinstance(one, HeightMap) for one in scene.contacts):  # a peak takes as long as a run
            unchanged = "quantisation" in effects
            return Choice(scene.with_effects(effects.items(), None if unchanged else accuracy), tolerance, {}, error)
        fingers = range(len(scene.arrays))
        if evaluated:
            times = [hardest_times(scene, finger, HARDEST) for finger in fingers]
        else:  # a lower peak is safe
            times = [key_times(scene, finger, HARDEST)[0] for finger in fingers]
        peak = _peak(scene.with_effects((), accuracy), times)
        error += step_of(scene) / peak
        if error > tolerance:  # any change, however small, may become a step of the converter
            return Choice(scene.with_effects(effects.items()), tolerance, {}, 0.0)
        for name, size in bounds(effects, readings(scene, AMPLIFIED * peak)).items():
            if error + size / peak <= tolerance:
                left_out[name] = size / peak
                error += size / peak
        chosen = scene.with_effects([one for one in effects.items() if one[0] not in left_out], accuracy)
        for name in evaluated:
            fewer = chosen.with_effects([one for one in chosen.effects if one[0] != name])
            size = SAFE * _difference(chosen, fewer, times) / peak
            if error + size <= tolerance:
                left_out[name], error, chosen = size, error + size, fewer
    kept = [one for one in effects.items() if one[0] not in left_out]
    return Choice(scene.with_effects(kept, accuracy), tolerance, left_out, error)


def bounds(effects: dict[str, Any], on: Readings) -> dict[str, float]:
    """The upper bounds of those effects that have one."""
    return {name: float(bound(effects[name], on)) for name, bound in BOUNDS.items() if name in effects}


def readings(scene: Scene, largest: float) -> Readings:
    """The arguments of bounds in a scene."""
    taxels = max(array.rows * array.cols for array in scene.arrays)
    return Readings(largest, scene.full_scale * scene.unit(0), taxels, scene.samples, scene.rate)


def step_of(scene: Scene) -> float:
    """The step of the converter in the unit of the readings, 0 without one."""
    effect = dict(scene.effects).get("quantisation")
    if effect is None or effect.off:
        return 0.0
    return float(effect.span * scene.full_scale * scene.unit(0) / 2.0 ** (effect.bits - 1))


def _peak(scene: Scene, times: list[Floats]) -> float:
    """The largest reading of the fields at some times of every finger; full scale where nothing presses."""
    fields = [scene.skin.field(finger, at).values for finger, at in enumerate(times)]
    return max(float(np.abs(values).max()) for values in fields) or scene.full_scale * scene.unit(0)


def _difference(one: Scene, other: Scene, times: list[Floats]) -> float:
    """The largest difference of two scenes' fields, without random effects, at some times of every finger."""
    fields = [
        [scene.fixed_field(scene.skin.field(finger, at), finger).values for scene in (one, other)]
        for finger, at in enumerate(times)
    ]
    return max(float(np.abs(a - b).max()) for a, b in fields)
