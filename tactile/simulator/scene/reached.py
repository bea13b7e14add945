"""What presses on a finger and what its taxels feel at most: forces, widths of contacts and strains of a recording."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import FORCE, F
from tactile.simulator.effect import is_off
from tactile.simulator.field import Contact, Field
from tactile.simulator.ideal_skin import IdealSkin
from tactile.simulator.scene.hardest_frames import hardest_frames, most_strained

MOMENTS = 64
"""Frames looked at, beside those at the keyframes and the hardest ones."""
DEEP = 0.3
"""Indentation over thickness, and strain, from which linear rubber is off by about a third."""
ASIDE, NEAR = 6.0, 0.02
"""Deviations of a tremble that few frames pass, and what of the depth that may be before a load is nearer for it."""


class TheScene(Protocol):
    """What is asked of a scene, which asks for its range itself."""

    @property
    def contacts(self) -> Sequence[Contact]: ...  # noqa: D102 - bodies
    @property
    def effects(self) -> Sequence[tuple[str, Any]]: ...  # noqa: D102 - as a scene has them
    @property
    def arrays(self) -> Sequence[Any]: ...  # noqa: D102 - of taxels
    @property
    def rate(self) -> float: ...  # noqa: D102 - [Hz]
    @property
    def samples(self) -> int: ...  # noqa: D102 - frames
    @property
    def skin(self) -> IdealSkin: ...  # noqa: D102 - without effects
    def affected(  # noqa: D102 - fields behind effects
        self, stream: Iterable[Field], stage: str, effects: Iterable[tuple[str, Any]], finger: int
    ) -> Iterator[Field]: ...


class Reached(NamedTuple):
    """The largest ``strain``, and of every contact the largest normal force [N] and radius [m] of its round contact.

    A strain below ``DEEP`` is a bound of it.
    """

    strain: float
    forces: Floats
    wide: Floats


def reached(fields: Iterable[Field]) -> Reached:
    """What is reached in some fields of one finger."""
    found = Reached(0.0, np.zeros(1), np.zeros(1))
    for field in fields:
        loads = field.loads
        wide = np.zeros(loads.totals.shape[1])
        for disc in loads.discs:
            np.maximum.at(wide, disc.owner, disc.radii.max(axis=0, initial=0.0))
        forces = loads.totals[..., F].max(axis=0, initial=0.0)
        found = Reached(
            max(found.strain, _strain(field)), np.maximum(found.forces, forces), np.maximum(found.wide, wide)
        )
    return found


def _strain(field: Field) -> float:
    """The largest strain (u_xz, u_yz, u_zz) where the taxels lie, whatever they feel.

    From the loads, as no normal strain follows from the stresses that are felt: what presses from the sides is missing.
    Under bumps, of which only the stress is known, that is left out: a bump is free to its sides.
    """
    if (bound := most_strained(field)) <= DEEP:
        return bound
    medium = field.medium
    if medium.quantity == "stress" and field.bumps is None:
        felt = replace(field, medium=replace(medium, quantity="strain"))
        felt.__dict__["loads"] = field.loads  # they do not depend on what is felt
        return float(np.abs(felt.values).max(initial=0))
    size = np.abs(field.values).max(axis=(0, 1, 2), initial=0)
    if medium.quantity == "stress":
        size = size / (2 * medium.shear_modulus, 2 * medium.shear_modulus, medium.modulus)
    return float(size.max())


def looked_at(scene: TheScene, finger: int) -> Field:
    """The field of a finger behind its fixed effects, where something may be said of it: in a few of all frames.

    Evenly spread ones, those at which bodies have their keyframes and loads are at their hardest, and, where taxels may
    be strained too much at all, those in which hard loads pass near them.
    """
    last, times, told = (scene.samples - 1) / scene.rate, [], True
    times.append(np.linspace(0, last, min(MOMENTS, scene.samples)))
    for one in scene.skin.field(finger, np.zeros(1)).contacts:
        path = getattr(one, "path", None)
        if path is None:
            told = False  # by no keyframe
            continue
        path = path[(path[:, 0] >= 0) & (path[:, 0] <= last)]
        if any(one is body for body in scene.contacts):
            times.append(path[:, 0])
        elif len(path):  # in the frames beside: a force between two of them is not seen
            hard = path[np.square(path[:, 1:][:, FORCE]).sum(axis=1).argmax(), 0] * scene.rate
            times.append(np.array([np.floor(hard), np.ceil(hard)]) / scene.rate)
    field = _still(scene, finger, times)
    if told and most_strained(field) <= DEEP:
        return field
    return _still(scene, finger, [*times, hardest_frames(field, scene.samples, scene.rate)])


def _still(scene: TheScene, finger: int, times: Sequence[Floats]) -> Field:
    sure = [(name, effect) for name, effect in scene.effects if not effect.RANDOM]
    at, last = np.unique(np.concatenate(times)), (scene.samples - 1) / scene.rate
    at = at[(at >= 0) & (at <= last)]
    return next(scene.affected(scene.skin.fields(finger, [(0, at)]), "field", sure, finger))


def may_reach_more(scene: TheScene, field: Field, matters: Callable[[Reached], bool]) -> bool:
    """Whether what shakes contacts may make something of it that matters: as far as it raises them in all frames."""
    shaking = [effect for _, effect in scene.effects if hasattr(effect, "rises") and not is_off(effect)]
    if not shaking:
        return False
    from tactile.simulator.held_needle import lifted  # only where called for

    raised = lifted(field, [(effect.rises(scene.samples), effect.tip_radius) for effect in shaking])
    aside = ASIDE * max(getattr(effect, "lateral", 0.0) for effect in shaking)
    try:
        return matters(reached([raised])) or (aside > NEAR * field.array.depth and most_strained(raised) > DEEP)
    except InputError:  # raised so far, one goes through the cover
        return True
