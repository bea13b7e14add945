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
"""The ``none`` of a parameter that is no strength."""
ANSWERS = ("reach", "strays", "rises", "most", "saves", "passes", "behind", "grain")
"""What a class may say so that ``effects = "auto"`` may leave it out: see ``effects``."""


def parameter(
    typical: Any, low: float = 0.0, high: float = math.inf, *, key: str = "", unit: float = 1.0, none: Any = NEEDED
) -> Any:
    """A field of an effect.

    Arguments: ``typical`` value, its default; ``low``, ``high``: the range of a number, both allowed; ``key`` in the
    effect's table of a scene, the field's name unless given, and the ``unit`` of that key in SI units; ``none``: its
    value at strength zero, of the parameters that are strengths.
    """
    return field(default=typical, metadata={"range": (low, high), "key": key, "unit": unit, "none": none})


@dataclass_transform(frozen_default=True)
def effect(
    stage: str, random: bool = False, normal: bool = False, assumed: bool = True, *, price: tuple[float, float]
) -> Callable[[type[Kind]], type[Kind]]:
    """Make a class an effect: a frozen dataclass of parameters with what ``effects.Effect`` says of them.

    Arguments: ``price``: time of a run [us], however short, and of every reading [ns], at its typical strength alone.

    Its parameters are refused outside their ranges, and infinite where that is not strength zero, before its own
    ``__post_init__``. Where all strengths are zero its
    call is left out: the stream goes on as it comes.
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
            return iter(stream) if is_off(self) else act(self, stream, random)

        kind.__post_init__, kind.__call__ = check, call
        kind = dataclass(frozen=True)(kind)
        kind.STAGE, kind.RANDOM, kind.NORMAL, kind.ASSUMED = stage, random or normal, normal, assumed
        kind.PRICE = price[0] * 1e-6, price[1] * 1e-9
        kind.KEYS = {one.metadata["key"] or one.name: (one.name, one.metadata["unit"]) for one in fields(kind)}
        kind.SAYS = frozenset(name for name in ANSWERS if hasattr(kind, name))
        kind.NONE = {one.name: one.metadata["none"] for one in fields(kind) if one.metadata["none"] is not NEEDED}
        return given

    return define


def is_off(effect: Any) -> bool:
    """Whether all strengths of an effect are zero."""
    return bool(effect.off)


def sticks(effect: Any) -> bool:
    """Whether bodies stick with a fixed effect on fields, or it does not say what it does: they press otherwise."""
    return getattr(effect, "sticks", False) or not hasattr(effect, "most")


def within(name: str, value: Any, low: float = 0.0, high: float = math.inf) -> None:
    """Refuse a value outside low .. high, both allowed.

    Raises:
        InputError: it is outside, or not a number.
    """
    if not low <= value <= high:
        wanted = f"at least {low:g}" if math.isinf(high) else f"from {low:g} to {high:g}"
        raise InputError(f"{name} = {value!r}, {wanted} wanted")
