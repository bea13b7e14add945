"""Effects of a scene: one file each, imported only when a scene names it. A new one is a file and a name in MODULES.

An effect is a frozen value as ``simulator.effect`` makes them, called with a stream (fields before the electronics,
batches of frames after) and a random generator; it gives the stream back, changed. At strength zero it changes
nothing. Its class says

    STAGE   "field" or "frames": where in the chain it acts
    RANDOM  whether it draws random numbers
    ASSUMED whether ``effects = "auto"`` takes a scene to have it that does not describe it; not so the faults of a
            single array, which nobody can guess
    NORMAL  whether what it changes is normally distributed, or nearly: such changes add up by their squares
    PRICE   about what it takes in a run: time of a finger's recording [s], however short, and of every reading
    KEYS    the keys of its table in a scene: name -> (attribute, factor to SI units)
    NONE    the attributes that make its strength zero, and their values then

and, so that ``effects = "auto"`` may leave it out,

    reach(seen) -> float             an effect on frames: bound of what it changes, given bounds of the readings
    strays(field, slopes, frames) -> float   a random one on fields: the same, for frames of a field
    rises(frames) -> float           a random one that raises the surface under contacts: how far [m] at most
    sticks                           a fixed one on fields with which bodies press otherwise, however they are pushed
    smooths                          a fixed one on fields that averages them, and makes no reading larger
    most(slopes) -> float            a fixed one on fields, a bound that needs no trial, whatever the others are, from
                                     how fast readings of the skin without effects change from place to place
    saves(points, layered) -> float  what leaving it out saves of a frame's time, where that is much or nothing, and
                                     loads press at points or not, on a layer or not
    passes(seen) -> float            where it lets a change before it grow: by how much at most
    behind(seen) -> Seen             where the bounds do not grow by all that it changes: those behind it
    grain(seen) -> float             where the smallest change before it may become a large one: that

What holds of something random holds for all seeds but one in a million.

Its attributes' defaults are typical values, which estimates use where a scene does not give any.
"""

import importlib
from collections.abc import Mapping
from dataclasses import fields
from functools import partial
from typing import Any, ClassVar, Protocol, cast

from cnnsim.support import InputError, naming
from cnnsim.support.error_list import read_all
from cnnsim.support.toml_file import check_keys, located, take
from cnnsim.support.values import is_number
from tactile.simulator.effect import within

MODULES = (
    "needle_vibration",
    "surface_waviness",
    "adhesion",
    "mounting.curved_fingertip",
    "mounting.cover_error",
    "mounting.misplacement",
    "poisson_ratio",
    "finite_tip",
    "finite_thickness",
    "taxel_area",
    "strain_nonlinearity",
    "viscoelastic",
    "hysteresis",
    "crosstalk",
    "electronics.taxel_mismatch",
    "electronics.temperature",
    "motor_noise",
    "drift",
    "electronics.pink_noise",
    "read_noise",
    "electronics.clipping",
    "electronics.low_pass",
    "electronics.multiplex_skew",
    "dead_taxels",
    "quantisation",
    "frame_timing",
)
"""The effects' files in the order in which they act: what presses, the cover, the taxels, the electronics."""
ORDER = tuple(module.rpartition(".")[2] for module in MODULES)
"""Names of all effects in that order."""


class Effect(Protocol):
    """What all effects have in common: these attributes."""

    STAGE: ClassVar[str]
    RANDOM: ClassVar[bool]
    NORMAL: ClassVar[bool]
    ASSUMED: ClassVar[bool]
    PRICE: ClassVar[tuple[float, float]]
    KEYS: ClassVar[Mapping[str, tuple[str, float]]]
    NONE: ClassVar[Mapping[str, Any]]


def effect_class(name: str) -> type[Effect]:
    """Import the effect's file and return its class: ``read_noise`` is ``ReadNoise``.

    Raises:
        InputError: no effect of that name.
    """
    check_keys({name: None}, ORDER, "effect")
    module = importlib.import_module(f"tactile.simulator.effects.{MODULES[ORDER.index(name)]}")
    return cast(type[Effect], getattr(module, "".join(part.capitalize() for part in name.split("_"))))


def read_effect(name: str, table: Mapping[str, Any], where: str) -> Effect:
    """The effect that a scene's table describes; what the table does not say is typical.

    Raises:
        InputError: an unknown effect or key, a value of a wrong type or out of range.
    """
    kind = effect_class(name)
    check_keys(table, tuple(kind.KEYS), where)
    typical, parts = kind(), {part.name: part for part in fields(cast(Any, kind))}

    def value(key: str) -> Any:
        attribute, factor = kind.KEYS[key]
        default = getattr(typical, attribute)
        wanted = float if default is None else list if isinstance(default, tuple) else type(default)
        found: Any = take(table, key, wanted, where)
        found = found * factor if isinstance(found, float) else found
        with located(table, key), naming(where):
            if is_number(found):
                within(attribute, found, *parts[attribute].metadata["range"])
        return found

    values = read_all(where, *(partial(value, key) for key in table))
    with located(table, next(iter(table), None)), naming(where):
        return kind(**{kind.KEYS[key][0]: one for key, one in zip(table, values, strict=True)})


def make_effect(name: str, **parameters: Any) -> Effect:
    """Return the effect of that name; parameters that are not given are typical.

    Arguments: ``parameters`` by the names of the effect's attributes, in SI units, such as ``rms`` of "read_noise".

    Raises:
        InputError: no effect or parameter of that name, or a value out of range.
    """
    if not isinstance(name, str):
        raise InputError(f"effect {name!r}; the name of one wanted, such as 'read_noise'")
    kind = effect_class(name)
    check_keys(parameters, tuple(attribute for attribute, _ in kind.KEYS.values()), f"effect {name}")
    typical = kind()
    for key, value in parameters.items():
        if is_number(getattr(typical, key)) and not is_number(value):
            raise InputError(f"effect {name}: {key} = {value!r}; a number wanted")
    return kind(**parameters)


def effect_name(effect: Effect) -> str:
    """Return the name in `ORDER` of an effect.

    Raises:
        InputError: something else than an effect.
    """
    name = type(effect).__module__.rpartition(".")[2]
    if name not in ORDER:
        raise InputError(f"{effect!r}; an effect wanted, such as make_effect('read_noise', rms=0.001)")
    return name


def without(kind: type[Effect]) -> Effect:
    """The effect of that class at strength zero."""
    return kind(**kind.NONE)
