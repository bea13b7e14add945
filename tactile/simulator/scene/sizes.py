"""Sizes of effects as they are in a scene: what taking one away or adding one changes, the others as they are."""

from collections.abc import Iterable

from tactile.simulator.scene.effect_bounds import EffectBounds, Named
from tactile.simulator.scene.estimate import Sample
from tactile.simulator.scene.scene import Scene

TRIED = 64
"""Frames on which effects on fields are tried: each costs as much as the field, or many times that."""


def sizes_in(scene: Scene, effects: Iterable[Named]) -> dict[str, float]:
    """Return the size of every effect in a scene, relative to the peak: the largest change of a reading.

    Of an effect of the scene: when it alone is taken away; of another: when it alone is added. What is fixed is
    measured, effects on fields on up to TRIED frames; what is random is a bound that all seeds but one in a thousand
    keep.
    """
    every, on = list(effects), dict(scene.effects)
    found = EffectBounds(scene, every, on)
    bounds = {name: size + found.steps_behind(name) * (size > 0) for name, size in found.sizes().items()}
    whole, few = Sample(scene), Sample(scene, TRIED)
    with_all, with_few = whole.run(scene.effects), few.run(scene.effects)
    sizes: dict[str, float] = {}
    for name, effect in every:
        if effect.RANDOM:
            sizes[name] = bounds[name]
            continue
        other = [(n, e) for n, e in every if (n in on) != (n == name)]
        if effect.STAGE == "field":
            sizes[name] = few.gap(few.run(other), with_few)
        else:
            sizes[name] = whole.gap(whole.run(other), with_all)
    return sizes
