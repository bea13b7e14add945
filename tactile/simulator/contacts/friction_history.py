"""History of a contact's friction along its path: states at keyframes and at the ends of sliding."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import FORCE, SHEAR, F
from tactile.simulator.contacts.friction import Carry, FrictionState, follow, load_to, untouched

LOOKS = 33
"""Samples between two keyframes, denser after the first: contacts begin there."""
HALVINGS = 40
"""Bisections of an interval between samples, to 1e-12 of it."""


class FrictionHistory(NamedTuple):
    """States of friction: before the first of the ``times`` (n,) [s], and from each of them on (n + 1).

    ``carry``: how rings change with the normal force, see ``friction.load_to``.
    """

    times: Floats
    states: list[FrictionState]
    carry: Carry | None

    def at(self, times: Floats, rows: Floats) -> list[FrictionState]:
        """Return the states at other times under loads (times, 5 or more)."""
        last = np.searchsorted(self.times, times, side="right").tolist()
        return [load_to(self.states[k], row[F], row[SHEAR], self.carry) for k, row in zip(last, rows, strict=True)]

    def terms(self, times: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Return the terms of ``friction.follow``, each from the last state: in between loads change linearly."""
        before = np.searchsorted(self.times, times, side="right")
        return follow(self.states, before, rows[:, FORCE], self.carry)


def history(
    keys: Floats, rows_at: Callable[[Floats], Floats], friction: float, carry: Carry | None = None
) -> FrictionHistory:
    """Return the history of a contact with keyframes at the times ``keys`` [s]."""
    times, states = with_sliding_ends(keys, rows_at, friction), [untouched(friction)]
    for row in rows_at(times):
        states.append(load_to(states[-1], row[F], row[SHEAR], carry))
    return FrictionHistory(times, states, carry)


def with_sliding_ends(keys: Floats, rows_at: Callable[[Floats], Floats], friction: float) -> Floats:
    """Return the times [s] of keyframes and of ends of sliding, where |(Q, R)| falls below friction * F.

    A step of ``friction.load_to`` is exact for forces that change linearly unless the whole contact slides in between:
    sliding erases the memory, and the force is friction * F until it sticks.

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
    """Return the excess [N] of the tangential force over friction."""
    rows = rows_at(times.ravel())
    found = np.hypot(*rows[:, SHEAR].T) - friction * np.maximum(rows[:, F], 0)
    return np.asarray(found.reshape(times.shape))
