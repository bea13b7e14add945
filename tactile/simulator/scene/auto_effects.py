"""Automatic choice of effects by size: ``effects = "auto"`` keeps what matters in a scene and says what it left out."""

from dataclasses import dataclass
from typing import Any

from cnnsim.support import InputError
from tactile.simulator.effects import ORDER, effect_class
from tactile.simulator.scene.estimate import Named, Sample
from tactile.simulator.scene.scene import Scene


@dataclass(frozen=True)
class Choice:
    """What the automatic choice decided.

    ``scene`` with the chosen effects; ``sizes``: estimated size of every effect, relative to the peak; ``left_out``:
    name -> size, the bound of what its absence costs; ``together``: effects smaller than the tolerance that are on
    because without them the others left out would have exceeded it together; ``joint``: measured error of the choice
    against everything on, over the sample.
    """

    scene: Scene
    tolerance: float
    sizes: dict[str, float]
    left_out: dict[str, float]
    together: tuple[str, ...]
    joint: float


def candidates(scene: Scene) -> list[Named]:
    """Every effect there is: as the scene describes it, or typical; on bumps not those of a flat cover."""
    named = dict(scene.effects)
    effects = [(name, named[name] if name in named else effect_class(name)()) for name in ORDER]
    return [(name, effect) for name, effect in effects if scene.bumps is None or effect.STAGE != "field"]


def size_of(sample: Sample, name: str, effect: Any) -> float:
    """Estimated size of one effect in a scene: the largest change it makes on its own, relative to the peak."""
    alone = sample.gap(sample.run([(name, effect)]), sample.run([]))
    return alone * (sample.stretch if effect.RANDOM else 1.0)


def choose(scene: Scene, tolerance: float) -> Choice:
    """Turn on exactly the effects whose estimated size exceeds the tolerance.

    All effects are candidates: those that the scene describes with its numbers, the others at typical strength. As
    small errors add, the choice is then run against everything on, over the sample; while the error exceeds the
    tolerance, the effect that mends most of it is turned on too.

    Raises:
        InputError: a tolerance that is not positive.
    """
    if not tolerance > 0:
        raise InputError(f"tolerance {tolerance}, a positive number wanted")
    sample = Sample(scene)
    effects = candidates(scene)
    sizes = {name: size_of(sample, name, effect) for name, effect in effects}
    on = {name for name, size in sizes.items() if size > tolerance}
    everything = sample.run(effects)

    def error(names: set[str]) -> float:
        return sample.gap(sample.run([(name, effect) for name, effect in effects if name in names]), everything)

    together: list[str] = []
    joint = error(on)
    while joint > tolerance / sample.stretch:
        # which one mends most is measured, for small alone is not small beside others: what Poisson's ratio does
        # at the bottom of a layer is large
        off = [name for name in sizes if name not in on]
        worth = [name for name in off if sizes[name] > tolerance / (4 * len(off))] or off
        joint, name = min((error({*on, name}), name) for name in worth)
        on.add(name)
        together.append(name)
    chosen = scene.with_effects((name, effect) for name, effect in effects if name in on)
    left_out = {name: sizes[name] for name in sizes if name not in on}
    return Choice(chosen, tolerance, sizes, left_out, tuple(together), joint)
