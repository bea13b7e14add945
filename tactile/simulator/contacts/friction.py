"""Coulomb friction on a round contact: partial slip from its rim inwards, with the memory of past loads."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError, Integers

Vector = Floats
Carry = Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]
"""Maps rings (n, k) and shares (n, k, 2) of old states to those at new normal forces (n,)."""


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
        """The tangential force (Q, R) [N]."""
        total: Vector = self.friction * (np.diff(self.ends, prepend=0.0) @ self.shares)
        return total

    def terms(self) -> tuple[Vector, Vector]:
        """Return normal forces s_k (n,) and tangential forces (n, 2) [N], to be spread like p(s_k) and summed."""
        following = np.vstack([self.shares[1:], np.zeros((1, 2))])
        return self.ends, self.friction * self.ends[:, None] * (self.shares - following)


def untouched(friction: float) -> FrictionState:
    """Return the state without a contact.

    Raises:
        InputError: a negative friction coefficient.
    """
    if not (np.isfinite(friction) and friction >= 0):
        raise InputError(f"friction coefficient {friction}, a number from 0 up wanted")
    return FrictionState(friction, np.zeros(0), np.zeros((0, 2)))


def load_to(before: FrictionState, normal: float, tangential: Vector, carry: Carry | None = None) -> FrictionState:
    """Return the state after a straight change to the forces ``normal`` and ``tangential`` (2,) [N].

    First the circle grows or shrinks; a new ring takes as much of the change as it can. The rest slips: from the rim
    inwards rings take the full share in the direction of the rest, down to the circle that sticks. Beyond
    friction * normal the whole contact slides. ``carry``: how rings change with the normal force, None if they do not.
    """
    from tactile.simulator.contacts.friction_loops import rooms, step  # compiled

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
    """Return the ``terms`` after ``load_to`` for many loads (n, 3), rows (Q, R, F), each from one of the states.

    Returns normal forces (n, k) and tangential forces (n, k, 2) [N], with pressures p(s_k), 0 where there is no ring.
    """
    from tactile.simulator.contacts.friction_loops import rooms, steps  # compiled

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
