"""Checks of what a scene says, as it is made: numbers, arrays, what presses on them, and where it is computed."""

from typing import Any

from cnnsim.support import InputError
from tactile.simulator.taxels import FINEST

WHERE = (("cpu", "float64"), ("opencl", "float64"), ("opencl", "float32"))
"""Backends and numbers in which loads are summed."""
SINGLE = 1e-5
"""The finest accuracy that sums in float32 keep."""


def check(scene: Any) -> None:  # a `Scene`, which is made by its help
    """Raise the `InputError` that `Scene` names, if one of its fields says what cannot be."""
    for name in ("rate", "duration", "modulus", "full_scale"):
        if not 0 < getattr(scene, name) < float("inf"):
            raise InputError(f"scene {scene.title!r}: {name} {getattr(scene, name)}, a positive number wanted")
    finest = FINEST if scene.dtype == "float64" else SINGLE
    if scene.accuracy != 0 and not finest <= scene.accuracy <= 0.1:
        raise InputError(
            f"scene {scene.title!r}: accuracy {scene.accuracy:g} in {scene.dtype}; from {finest:g} to 0.1 of the peak "
            "wanted, or 0 for the finest there is"
        )
    if (scene.backend, scene.dtype) not in WHERE:
        wanted = ", ".join(f"{backend} in {dtype}" for backend, dtype in WHERE)
        raise InputError(f"scene {scene.title!r}: {scene.backend} in {scene.dtype}; one of {wanted} wanted")
    names = [array.name for array in scene.arrays]
    if not names or len(set(names)) < len(names):
        raise InputError(f"scene {scene.title!r}: arrays {names}, at least one and no name twice wanted")
    for array in scene.arrays:
        if array.quantity == "force":
            raise InputError(f"scene {scene.title!r}: array {array.name!r} of force; strain or stress wanted")
    for contact in (*scene.loads, *scene.contacts):
        if contact.finger not in range(len(names)):
            raise InputError(f"scene {scene.title!r}: {contact!r}; a finger from 0 to {len(names) - 1} wanted")
    check_effects(scene)


def check_effects(scene: Any) -> None:
    """Raise the `InputError` that `Scene` names, if its effects do not fit the rest of it."""
    if scene.bumps is None:
        return
    flat = [name for name, effect in scene.effects if effect.STAGE == "field"]
    if flat:
        raise InputError(f"scene {scene.title!r}: {', '.join(flat)} on bumps; effects on a flat cover's field")
