"""Threshold choices of the user, from an array file or the command line: floors, sigmas, bare signs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

from cnnsim.support import InputError, naming
from cnnsim.support.error_list import ErrorList
from cnnsim.support.toml_file import located, take, take_numbers
from tactile.thresholds.levels import SIGMAS, Sigmas
from tactile.thresholds.threshold import SIGN, Threshold


class ChosenThresholds(NamedTuple):
    """Floors of ``shear`` and ``contact``, None for the defaults of the quantity, and ``sigmas``."""

    shear: Threshold | None
    contact: Threshold | None
    sigmas: Sigmas


@dataclass(frozen=True)
class ThresholdChoices:
    """Thresholds chosen by the user; None is no choice.

    ``dead_band``, ``hysteresis`` and ``contact_level`` are lower limits [unit of the quantity]; hysteresis None is half
    the dead band; ``sigmas`` as in `Sigmas`; ``sign_code``: bare signs without a dead band.
    """

    dead_band: float | None = None
    hysteresis: float | None = None
    contact_level: float | None = None
    sigmas: tuple[float, float, float] | None = None
    sign_code: bool = False

    def but(self, chosen: "ThresholdChoices") -> Self:
        """Return these choices, each replaced by that of ``chosen`` where it has one.

        A dead band replaces bare signs, and bare signs replace a dead band.
        """
        names = ("dead_band", "hysteresis", "contact_level", "sigmas")
        changed: dict[str, Any] = {name: getattr(chosen, name) for name in names if getattr(chosen, name) is not None}
        if chosen.sign_code:
            changed |= {"sign_code": True, "dead_band": None, "hysteresis": None}
        elif chosen.dead_band is not None:
            changed["sign_code"] = False
        return replace(self, **changed)

    def thresholds(self) -> ChosenThresholds:
        """Return the chosen thresholds.

        Raises:
            InputError: thresholds that contradict each other, or invalid numbers.
        """
        if self.sign_code and (self.dead_band, self.hysteresis) != (None, None):
            raise InputError("sign_code has no dead band; dead_band and hysteresis not wanted with it")
        if self.hysteresis is not None and self.dead_band is None:
            raise InputError("hysteresis needs a dead_band, in the unit of the quantity; both wanted")
        shear = SIGN if self.sign_code else None
        if self.dead_band is not None:
            shear = Threshold(self.dead_band, self.dead_band / 2 if self.hysteresis is None else self.hysteresis)
        contact = None if self.contact_level is None else Threshold(self.contact_level, self.contact_level / 2)
        return ChosenThresholds(shear, contact, SIGMAS if self.sigmas is None else Sigmas(*self.sigmas))


KEYS = tuple(ThresholdChoices.__dataclass_fields__)
"""Keys of a table ``[thresholds]``, named like the options."""


def take_choices(table: Mapping[str, Any], faults: ErrorList, place: str) -> ThresholdChoices:
    """Return the choices of a table ``[thresholds]``, the default ones where ``faults`` were found.

    ``place`` names the table in messages. Unknown keys, invalid values and contradicting thresholds are added to
    ``faults``.
    """
    faults.check(table, KEYS, place)
    if not isinstance(table, Mapping):
        return ThresholdChoices()
    found = dict[str, Any]()
    for name in (key for key in table if key in KEYS):
        with faults.collecting(), located(table, name):
            found[name] = _value(table, name, place)
    if len(found) < len(table):
        return ThresholdChoices()
    choices = ThresholdChoices(**found)
    with faults.collecting(), located(table), naming(place):
        choices.thresholds()
    return choices


def _value(table: Mapping[str, Any], name: str, place: str) -> Any:
    if name == "sign_code":
        return take(table, name, bool, place)
    if name == "sigmas":
        sigmas = take_numbers(table, name, 3, place)
        with naming(f"{place}: {name}"):
            Sigmas(*sigmas)
        return tuple(sigmas)
    number = take(table, name, float, place)
    if number < 0:
        raise InputError(f"{place}: {name} = {number!r}, a number from 0 wanted")
    return number
