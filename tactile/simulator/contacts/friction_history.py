"""History of a contact's friction along its path: from keyframe to keyframe, and from where what slides sticks."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import FORCE, SHEAR, F
from tactile.simulator.contacts.friction import Carry, FrictionState, follow, load_to, untouched

LOOKS = 33
"""Places in each stretch between keyframes that are looked at, closer where it begins: contacts begin there."""
HALVINGS = 40
"""Of such a stretch, after which 1e-12 of it is left."""


class FrictionHistory(NamedTuple):
    """States of friction: before the first of the ``times`` (n,) [s], and from each of them on (n + 1).

    ``carry``: what becomes of rings when the normal force changes, as ``friction.load_to`` has it.
    """

    times: Floats
    states: list[FrictionState]
    carry: Carry | None

    def at(self, times: Floats, rows: Floats) -> list[FrictionState]:
        """The states at other times under loads (times, 5 or more)."""
        last = np.searchsorted(self.times, times, side="right").tolist()
        return [load_to(self.states[k], row[F], row[SHEAR], self.carry) for k, row in zip(last, rows, strict=True)]

    def terms(self, times: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """What ``friction.follow`` gives from the moments before: a straight way of loading needs no more."""
        before = np.searchsorted(self.times, times, side="right")
        return follow(self.states, before, rows[:, FORCE], self.carry)


def history(
    keys: Floats, rows_at: Callable[[Floats], Floats], friction: float, carry: Carry | None = None
) -> FrictionHistory:
    """The history of a contact with keyframes at the times ``keys`` [s] (``with_sliding_ends``)."""
    times, states = with_sliding_ends(keys, rows_at, friction), [untouched(friction)]
    for row in rows_at(times):
        states.append(load_to(states[-1], row[F], row[SHEAR], carry))
    return FrictionHistory(times, states, carry)


def with_sliding_ends(keys: Floats, rows_at: Callable[[Floats], Floats], friction: float) -> Floats:
    """Times [s] of the keyframes and, between them, of the ends of sliding: where |(Q, R)| falls below friction * F.

    A step of ``friction.load_to`` is exact for forces that change along a straight way, if all of the contact does not
    slide on a part of it: what slides forgets what was before, and carries friction * F until it sticks.

    Arguments: ``keys`` (n,) [s]; ``rows_at`` (times) -> loads (times, 5 or more), without forces where nothing touches.
    """
    if len(keys) < 2 or not rows_at(keys)[:, SHEAR].any():
        return keys
    share = np.linspace(0, 1, LOOKS) ** 2
    times = keys[:-1, None] + np.diff(keys)[:, None] * share
    above = _above(times, rows_at, friction)
    ends = (above[:, :-1] > 0) & (above[:, 1:] < 0)
    low, high = times[:, :-1][ends], times[:, 1:][ends]
    for _ in range(HALVINGS if low.size else 0):
        middle = (low + high) / 2
        slides = _above(middle, rows_at, friction) > 0
        low, high = np.where(slides, middle, low), np.where(slides, high, middle)
    return np.union1d(keys, low)


def _above(times: Floats, rows_at: Callable[[Floats], Floats], friction: float) -> Floats:
    """By how much [N] the pull is larger than what friction holds."""
    rows = rows_at(times.ravel())
    found = np.hypot(*rows[:, SHEAR].T) - friction * np.maximum(rows[:, F], 0)
    return np.asarray(found.reshape(times.shape))
