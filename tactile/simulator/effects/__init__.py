"""Effects of a scene: one file each, imported only when a scene names it. A new effect is a file and a name in MODULES.

An effect is a frozen value made by ``simulator.effect``. It is called with a stream (fields before the electronics,
batches of frames behind it) and a random generator, and yields the changed stream. Attributes of its class:

    STAGE   "field" or "frames": where in the chain it acts
    RANDOM  whether it draws random numbers
    KEYS    the keys of its table in a scene: name -> (attribute, factor to SI units)
    NONE    the attributes that are strengths, with their values where the effect changes nothing

``off`` of an effect: all its strengths are zero. The defaults of its attributes are typical values. ``effects =
"auto"`` can drop an effect that has a bound in ``simulator.auto_effects``.
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
"""The effects' files in the order in which they act: contacts, cover, taxels, electronics."""
ORDER = tuple(module.rpartition(".")[2] for module in MODULES)
"""Names of all effects in that order."""


class Effect(Protocol):
    """Attributes that every effect has."""

    STAGE: ClassVar[str]
    RANDOM: ClassVar[bool]
    KEYS: ClassVar[Mapping[str, tuple[str, float]]]
    NONE: ClassVar[Mapping[str, Any]]
    off: bool


def effect_class(name: str) -> type[Effect]:
    """Import the effect's file and return its class: ``read_noise`` is ``ReadNoise``.

    Raises:
        InputError: no effect of that name.
    """
    check_keys({name: None}, ORDER, "effect")
    module = importlib.import_module(f"tactile.simulator.effects.{MODULES[ORDER.index(name)]}")
    return cast(type[Effect], getattr(module, "".join(part.capitalize() for part in name.split("_"))))


def read_effect(name: str, table: Mapping[str, Any], where: str) -> Effect:
    """The effect that a scene's table describes; missing keys have typical values.

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
