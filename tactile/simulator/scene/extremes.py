"""Largest forces, contact radii and strains of a finger over a recording."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.loads import FORCE, F
from tactile.simulator.field import Field
from tactile.simulator.scene.hardest_frames import hardest_frames, most_strained

if TYPE_CHECKING:
    from tactile.simulator.scene.scene import Scene

EVEN = 64
"""Number of evenly spread frames among the checked ones."""
DEEP = 0.3
"""Indentation over thickness, and strain, from which linear rubber is wrong by about a third."""
NEAR = 0.02
"""Displacement across, over the depth, up to which a vibrating load counts as no nearer to a taxel."""


class Extremes(NamedTuple):
    """The largest ``strain``, and of every contact the largest normal force [N] and radius [m] of a round contact.

    A strain below ``DEEP`` may be an upper bound.
    """

    strain: float
    forces: Floats
    radii: Floats


def extremes(fields: Iterable[Field]) -> Extremes:
    """The extremes over some fields of one finger."""
    found = Extremes(0.0, np.zeros(1), np.zeros(1))
    for field in fields:
        loads = field.loads
        radii = np.zeros(loads.totals.shape[1])
        for disc in loads.discs:
            np.maximum.at(radii, disc.owner, disc.radii.max(axis=0, initial=0.0))
        forces = loads.totals[..., F].max(axis=0, initial=0.0)
        found = Extremes(
            max(found.strain, _strain(field)), np.maximum(found.forces, forces), np.maximum(found.radii, radii)
        )
    return found


def _strain(field: Field) -> float:
    """The largest strain (u_xz, u_yz, u_zz) at the taxels, or an upper bound of it below ``DEEP``.

    Computed from the loads where stress is measured: normal strain does not follow from the measured stresses, which
    lack those along the surface. Under bumps, which are free to their sides, it does.
    """
    if field.array.quantity == "force":  # at the surface the strain under a point has no limit
        return 0.0
    if (bound := most_strained(field)) <= DEEP:
        return bound
    medium = field.medium
    if medium.quantity == "stress" and field.bumps is None:
        strained = replace(field, medium=replace(medium, quantity="strain"))
        return float(np.abs(strained.values).max(initial=0))
    size = np.abs(field.values).max(axis=(0, 1, 2), initial=0)
    if medium.quantity == "stress":
        size = size / (2 * medium.shear_modulus, 2 * medium.shear_modulus, medium.modulus)
    return float(size.max())


def checked_field(scene: "Scene", finger: int) -> Field:
    """The field of a finger with all fixed effects in the frames in which its models are checked.

    Evenly spread frames, keyframes and, where an upper bound of the strain is above ``DEEP``, the hardest frames.
    """
    times, by_path = key_times(scene, finger, EVEN)
    field = scene.fixed_field(scene.skin.field(finger, times), finger)
    if by_path and most_strained(field) <= DEEP:
        return field
    times = np.union1d(times, hardest_frames(field, scene.samples, scene.rate))
    return scene.fixed_field(scene.skin.field(finger, times), finger)


def hardest_times(scene: "Scene", finger: int, count: int) -> Floats:
    """Times [s] of the ``count`` frames in which the hardest loads are nearest to the taxels of a finger."""
    times, _ = key_times(scene, finger, count)
    return hardest_frames(scene.skin.field(finger, times), scene.samples, scene.rate, count)


def key_times(scene: "Scene", finger: int, even: int) -> tuple[Floats, bool]:
    """Times [s] of ``even`` evenly spread frames and of keyframes, and whether every contact follows a path."""
    last, by_path = (scene.samples - 1) / scene.rate, True
    times = [np.linspace(0, last, min(even, scene.samples))]
    for one in scene.skin.contacts(finger):
        path = getattr(one, "path", None)
        if path is None:
            by_path = False
            continue
        path = path[(path[:, 0] >= 0) & (path[:, 0] <= last)]
        if any(one is body for body in scene.contacts):
            times.append(path[:, 0])
        elif len(path):  # the frames before and after: a force between two frames is not read
            hard = path[np.square(path[:, 1:][:, FORCE]).sum(axis=1).argmax(), 0] * scene.rate
            times.append(np.array([np.floor(hard), np.ceil(hard)]) / scene.rate)
    found = np.unique(np.concatenate(times))
    return found[found <= last], by_path


def may_be_larger(scene: "Scene", field: Field, matters: Callable[[Extremes], bool]) -> bool:
    """Whether random displacements of the contacts may change the extremes of a ``field`` in a way that matters."""
    random = [effect for _, effect in scene.effects if effect.STAGE == "field" and effect.RANDOM and not effect.off]
    if not random:
        return False
    rig = field.rig
    for effect in random:
        rig = rig.with_move(_raised(effect.highest[1]), effect.tip_radius)
    raised = replace(field, rig=rig)
    aside = sum(effect.highest[0] for effect in random)
    try:
        return matters(extremes([raised])) or (aside > NEAR * field.array.depth and most_strained(raised) > DEEP)
    except InputError:  # a contact goes through the cover
        return True


def _raised(height: float) -> Callable[[Floats], tuple[Floats, Floats]]:
    return lambda places: (np.zeros_like(places), np.full(len(places), height))
