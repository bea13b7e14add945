"""Checks of the fields of a new scene: numbers, arrays, contacts and effects."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.values import is_number, is_whole
from tactile.elastic.sums.direct import FINEST

if TYPE_CHECKING:
    from tactile.simulator.scene.scene import Scene

COARSEST = 0.1
"""The coarsest accuracy of a field, relative to its peak."""


def check(scene: "Scene") -> None:
    """Raise the `InputError` that `Scene` names for a wrong field."""
    for name in ("rate", "duration", "modulus", "full_scale"):
        value = getattr(scene, name)
        if not is_number(value) or not 0 < value < float("inf"):
            raise InputError(f"scene {scene.title!r}: {name} {shown(value)}, a positive number wanted")
    if not isinstance(scene.title, str):
        raise InputError(f"scene {scene.title!r}: a text as title wanted")
    if not is_whole(scene.seed) or scene.seed < 0:
        raise InputError(f"scene {scene.title!r}: seed = {scene.seed!r}, a whole number from 0 up wanted")
    if not is_number(scene.accuracy):
        raise InputError(f"scene {scene.title!r}: accuracy {scene.accuracy!r}, a number wanted")
    if scene.accuracy != 0 and not FINEST <= scene.accuracy <= COARSEST:
        raise InputError(
            f"scene {scene.title!r}: accuracy {scene.accuracy:g}; from {FINEST:g} to {COARSEST:g} of the peak wanted, "
            "or 0 for the finest"
        )
    names = [array.name for array in scene.arrays]
    if not names or len(set(names)) < len(names):
        raise InputError(f"scene {scene.title!r}: arrays {names}, at least one and no name twice wanted")
    for array in scene.arrays:
        if array.quantity == "force" and (scene.bumps is not None or not array.shear):
            raise InputError(
                f"scene {scene.title!r}: array {array.name!r} of force on bumps or of the normal alone; three axes "
                "under a flat cover wanted, or strain or stress"
            )
    for contact in (*scene.loads, *scene.contacts):
        if not is_whole(getattr(contact, "finger", None)) or contact.finger not in range(len(names)):
            raise InputError(f"scene {scene.title!r}: {contact!r}; a finger from 0 to {len(names) - 1} wanted")
    flat = [name for name, effect in scene.effects if effect.STAGE == "field"]
    if scene.bumps is not None and flat:
        raise InputError(f"scene {scene.title!r}: {', '.join(flat)} on bumps; effects on a flat cover's field")


def listed(name: str, given: Any, kind: type[Any] | None = None) -> tuple[Any, ...]:
    """Return an iterable argument as a tuple.

    Raises:
        InputError: it is not iterable, or one of its items is not of this kind.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(f"{name} {shown(given)}; a list of them wanted: [{type(given).__name__}(...)]")
    things = tuple(given)
    for one in things:
        if kind is not None and not isinstance(one, kind):
            raise InputError(f"{name} with {shown(one)}; each a {kind.__name__} wanted")
    return things
