"""Event builder: turns transitions of detectors into events with codes, load, newtons and words."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Protocol

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.events.code import Code, hand_code
from tactile.events.detector import Transition, direction_of
from tactile.events.event import Data, Event
from tactile.events.hand import Hand
from tactile.inverse.load import Load

SIGMAS = 3.0
"""Least tangential load over its noise that has a direction."""


class FingerState(Protocol):
    """The attributes of a finger that the event builder reads."""

    @property
    def array(self) -> TaxelArray: ...  # noqa: D102 - the finger's array
    @property
    def code(self) -> Code: ...  # noqa: D102 - the current code of its comparators
    @property
    def travelled(self) -> tuple[float, float] | None: ...  # noqa: D102 - how far the load has travelled [m], if it is located


class EventBuilder:
    """Makes events from transitions, and keeps the lasting ones so that an end finds the event that began."""

    def __init__(self, fingers: Sequence[FingerState]) -> None:
        self._fingers = fingers
        self._open: dict[tuple[str, str], Event] = {}
        self._hand = Hand(len(fingers))

    def build(
        self, finger: FingerState, frame: Frame, load: Load, transitions: list[Transition], arrived: float
    ) -> tuple[tuple[Event, ...], tuple[Event, ...]]:
        """Return the events that begin and the events that end; the frame arrived at ``arrived`` (`perf_counter`)."""
        begun, ended = [], []
        code = finger.code
        hand = hand_code([one.code for one in self._fingers])
        for what in transitions:
            name = finger.array.name
            if what.change == "begins" and what.rule.kind == "hold" and load.F < 0:
                continue  # a pull is no hold: the zero is wrong
            if what.change == "begins":
                data = _data(what, load, code)
                rest = data["of_taxels"] if what.taxels is None else max(int(code.contact.sum()), 1)
                taxels = () if what.taxels is None else tuple((i, j) for i, j in np.argwhere(what.taxels).tolist())
                sure = 1.0 if what.taxels is None else min(len(taxels) / float(rest), 1.0)
                event = Event(
                    what.onset, name, frame.sequence, what.rule.kind, data, what.rule.words, code.arrows(),
                    code.ternary(), hand, perf_counter() - arrived, load, frame.t, None, taxels, round(sure, 4),
                )  # fmt: skip
                self._open[name, what.rule.kind] = event
                begun.append(event)
            else:
                known = self._open.pop((name, what.rule.kind), None)
                ended += [] if known is None else [_ended(known, what.end, finger.travelled)]
        joined, parted = self._hand.join(begun, ended)
        return (*begun, *joined), (*ended, *parted)

    def close(self, finger: FingerState, t: float) -> tuple[Event, ...]:
        """Return the lasting events of a finger, and those of the hand that end with them, ended at ``t`` [s]."""
        mine = [key for key in self._open if key[0] == finger.array.name]
        ended = [_ended(one, max(t, one.t), finger.travelled) for one in map(self._open.pop, mine)]
        return (*ended, *self._hand.join((), ended)[1])


def _data(what: Transition, load: Load, code: Code) -> Data:
    data: dict[str, str | int | float] = {"of_taxels": code.contact.size}
    noise = SIGMAS * np.hypot(*load.scatter[2:4])
    noisy = np.hypot(load.Q, load.R) <= noise  # False where the noise is unknown
    along = "" if noisy else direction_of((load.Q, load.R))
    direction = along if what.rule.along_load else what.direction
    if direction:
        data["direction"] = direction
    if what.sense:
        data["sense"] = what.sense
    if what.taxels is not None:
        data["taxels"] = int(what.taxels.sum())
    if np.isfinite(load.F):
        data["force_n"] = load.F
    if np.isfinite(load.Q) and np.isfinite(load.R):
        data["shear_n"] = float(np.hypot(load.Q, load.R))
    return data


def _ended(event: Event, end: float | None, travelled: tuple[float, float] | None) -> Event:
    """Return the event with its end; a slip also has the distance that the located load travelled.

    Its direction, that of the tangential load, is that of the travel where there is no tangential load.
    """
    data = dict(event.data)
    if travelled is not None and event.kind == "slip":
        dx, dy = travelled
        data |= {"length_m": float(np.hypot(dx, dy)), "dx_m": dx, "dy_m": dy}
        if "direction" not in data and (direction := direction_of(travelled)):
            data["direction"] = direction
    return replace(event, end=end, data=data)
