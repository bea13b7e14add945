"""Coulomb friction on a round contact that slips from its rim inwards, with its memory of past loads."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError, Integers

Vector = Floats
Carry = Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]
"""Rings (n, k) and shares (n, k, 2) of before, in terms of normal forces (n,) that press now."""


@dataclass(frozen=True)
class FrictionState:
    """The tangential traction of a round contact, as rings that slipped or stuck at different times.

    For similar materials the tangential traction is a sum of normal pressures: with p(s) the pressure when the
    normal force was s, q = mu * integral of D(s) dp(s), |D| <= 1. D is constant on rings: ``ends`` (n,) are their
    outer normal forces [N], rising to the present one, ``shares`` (n, 2) their D along x and y. So the resultant is
    (Q, R) = mu * sum of D * (force across the ring). ``sticks``: the normal force whose circle sticks [N];
    ``slipping``: the whole contact slides.

    Source: Cattaneo (1938), Mindlin and Deresiewicz (1953), Jaeger (1998); as memory diagrams Aleshin et al. (2015).
    Along one direction this is exact for any history; where the direction turns it is the usual approximation that
    traction follows the direction of the last change.
    """

    friction: float
    ends: Vector
    shares: Vector
    sticks: float = 0.0
    slipping: bool = False

    @property
    def force(self) -> Vector:
        """(Q, R) [N] that the contact carries."""
        total: Vector = self.friction * (np.diff(self.ends, prepend=0.0) @ self.shares)
        return total

    def terms(self) -> tuple[Vector, Vector]:
        """Normal forces s_k (n,) and tangential forces (n, 2) [N], spread like p(s_k): their sum is the traction."""
        following = np.vstack([self.shares[1:], np.zeros((1, 2))])
        return self.ends, self.friction * self.ends[:, None] * (self.shares - following)


def untouched(friction: float) -> FrictionState:
    """No contact yet.

    Raises:
        InputError: a negative friction coefficient.
    """
    if not (np.isfinite(friction) and friction >= 0):
        raise InputError(f"friction coefficient {friction}, a number from 0 up wanted")
    return FrictionState(friction, np.zeros(0), np.zeros((0, 2)))


def load_to(before: FrictionState, normal: float, tangential: Vector, carry: Carry | None = None) -> FrictionState:
    """The contact after the normal force went to ``normal`` and the tangential one to ``tangential`` (2,) [N].

    First the circle grows or shrinks; a new ring takes what share of the change it can. The rest is carried by
    slip: from the rim inwards everything takes the full share in the direction that is missing, down to the circle
    that sticks. Beyond friction * normal all of it slides and carries just that. ``carry``: what becomes of rings when
    the normal force changes, where they do not stay as they are.
    """
    from tactile.simulator.contacts.friction_loops import rooms, step  # compiled, so only where called for

    (ends,), (shares,) = rooms(1)
    count = before.ends.size
    ends[:count], shares[:count] = before.ends, before.shares
    if carry is not None and count:
        (ends,), (shares,) = carry(ends[None], shares[None], np.array([float(normal)]))
    pull = float(tangential[0]), float(tangential[1])
    count, sticks, slipping = step(float(before.friction), ends, shares, count, float(normal), *pull)
    return FrictionState(before.friction, ends[:count].copy(), shares[:count].copy(), sticks, slipping)


def follow(
    states: Sequence[FrictionState], which: Integers, loads: Floats, carry: Carry | None = None
) -> tuple[Vector, Vector]:
    """What ``load_to`` and ``terms`` give for many loads (n, 3), rows (Q, R, F), each from one of the states.

    Returns normal forces (n, k) and tangential forces (n, k, 2) [N], spread like p(s_k), 0 where there is no ring.
    """
    from tactile.simulator.contacts.friction_loops import rooms, steps  # the same

    known, shared = rooms(len(states))
    for row, share, state in zip(known, shared, states, strict=True):
        row[: state.ends.size], share[: state.ends.size] = state.ends, state.shares
    sizes = np.array([state.ends.size for state in states])
    if carry is not None and sizes.any():
        known, shared = carry(known[which], shared[which], loads[:, 2])
        sizes, which = sizes[which], np.arange(len(loads))
    ends, shares = rooms(len(loads))
    counts, mu = np.zeros(len(loads), np.int64), float(states[0].friction)
    steps(mu, known, shared, sizes, np.ascontiguousarray(which), np.ascontiguousarray(loads), ends, shares, counts)
    most = int(counts.max(initial=0))
    following = np.concatenate([shares[:, 1 : most + 1], np.zeros((len(loads), 1, 2))], axis=1)[:, :most]
    return ends[:, :most], mu * ends[:, :most, None] * (shares[:, :most] - following)
