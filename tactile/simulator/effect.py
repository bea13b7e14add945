"""Definition of an effect: its parameters with their ranges and keys, and what it does at strength zero."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields
from numbers import Real
from typing import Any, TypeVar, dataclass_transform

import numpy as np

from cnnsim.support import InputError

Kind = TypeVar("Kind")
NEEDED = object()
"""The ``none`` of a parameter that is not a strength."""


def parameter(
    typical: Any, low: float = 0.0, high: float = math.inf, *, key: str = "", unit: float = 1.0, none: Any = NEEDED
) -> Any:
    """A field of an effect.

    Arguments: ``typical`` value, the default; ``low``, ``high``: the allowed range of a number, ends included; ``key``
    in the effect's table of a scene, by default the field's name; ``unit`` of that key in SI units; ``none``: for a
    strength, its value where the effect changes nothing.
    """
    return field(default=typical, metadata={"range": (low, high), "key": key, "unit": unit, "none": none})


@dataclass_transform(frozen_default=True)
def effect(stage: str, random: bool = False) -> Callable[[type[Kind]], type[Kind]]:
    """Make a class an effect: a frozen dataclass of parameters with the attributes of ``effects.Effect``.

    Arguments: ``stage``: "field" or "frames"; ``random``: whether it draws random numbers.

    Values outside their ranges are refused, and infinite ones that are not strength zero. At strength zero the
    effect returns its stream unchanged.
    """

    def define(given: type[Kind]) -> type[Kind]:
        kind: Any = given
        own_check, act = getattr(kind, "__post_init__", None), kind.__call__

        def check(self: Any) -> None:
            for one in fields(self):
                value = getattr(self, one.name)
                if isinstance(value, Real):
                    within(one.name, value, *one.metadata["range"])
                    if math.isinf(value) and value != one.metadata["none"]:
                        raise InputError(f"{one.name} = {value!r}, a finite number wanted")
            if own_check is not None:
                own_check(self)
            off = all(getattr(self, name) == value for name, value in kind.NONE.items())
            object.__setattr__(self, "off", off)

        def call(self: Any, stream: Iterable[Any], random: np.random.Generator) -> Iterator[Any]:
            return iter(stream) if self.off else act(self, stream, random)

        kind.__post_init__, kind.__call__ = check, call
        kind = dataclass(frozen=True)(kind)
        kind.STAGE, kind.RANDOM = stage, random
        kind.KEYS = {one.metadata["key"] or one.name: (one.name, one.metadata["unit"]) for one in fields(kind)}
        kind.NONE = {one.name: one.metadata["none"] for one in fields(kind) if one.metadata["none"] is not NEEDED}
        return given

    return define


def within(name: str, value: Any, low: float = 0.0, high: float = math.inf) -> None:
    """Refuse a value outside low .. high, ends included.

    Raises:
        InputError: the value is outside, or not a number.
    """
    if not low <= value <= high:
        wanted = f"at least {low:g}" if math.isinf(high) else f"from {low:g} to {high:g}"
        raise InputError(f"{name} = {value!r}, {wanted} wanted")
