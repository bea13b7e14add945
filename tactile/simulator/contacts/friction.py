"""Coulomb friction on a round contact that slips from its rim inwards, with its memory of past loads."""

import math
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError

Vector = Floats
MEMORY = 12
"""Rings remembered; older, inner ones are merged beyond that."""


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


def load_to(before: FrictionState, normal: float, tangential: Vector) -> FrictionState:
    """The contact after the normal force went to ``normal`` and the tangential one to ``tangential`` (2,) [N].

    First the circle grows or shrinks; a new ring takes what share of the change it can. The rest is carried by
    slip: from the rim inwards everything takes the full share in the direction that is missing, down to the circle
    that sticks. Beyond friction * normal all of it slides and carries just that.
    """
    mu = before.friction
    size = float(np.hypot(*tangential))
    if normal <= 0 or mu == 0:
        return FrictionState(mu, np.zeros(0), np.zeros((0, 2)), 0.0, size > 0)
    if size >= mu * normal:
        return FrictionState(mu, np.array([normal]), (tangential / size)[None], 0.0, True)
    ends, shares = _cut(before.ends, before.shares, normal)
    old = float(ends[-1]) if ends.size else 0.0
    missing = tangential / mu - np.diff(ends, prepend=0.0) @ shares
    grown = normal - old
    gap = float(np.hypot(*missing))
    if gap <= grown:
        ring = missing / grown if grown > 0 else np.zeros(2)
        if grown > 0:
            ends, shares = np.append(ends, normal), np.vstack([shares, ring])
        return FrictionState(mu, *_short(ends, shares), normal)
    # |wanted - carried by the circle c| = normal - c; the ring from c out takes the full share. The difference
    # rises with c because shares are at most 1, so walking in from the rim finds the largest c first.
    wanted = tangential / mu
    inner = np.append(0.0, ends)
    carried = np.vstack([np.zeros(2), np.cumsum(np.diff(ends, prepend=0.0)[:, None] * shares, axis=0)])
    for k in range(len(ends) - 1, -1, -1):
        low, start = float(inner[k]), wanted - carried[k]
        if float(np.hypot(*start)) <= normal - low:
            step = _root(start, shares[k], normal - low, float(inner[k + 1]) - low)
            c = low + step
            rest = start - step * shares[k]
            way = rest / max(float(np.hypot(*rest)), 1e-300)
            kept = k + (1 if step > 0 else 0)
            new_ends = np.append(np.append(ends[:k], c) if step > 0 else ends[:k], normal)
            return FrictionState(mu, *_short(new_ends, np.vstack([shares[:kept], way])), c)
    return FrictionState(mu, np.array([normal]), (tangential / size)[None], 0.0, True)


def _root(start: Vector, share: Vector, left: float, most: float) -> float:
    """Largest step s in 0 .. most with |start - s share| = left - s."""
    # squared: (1 - |share|^2) s^2 - 2 (left - start . share) s + left^2 - |start|^2 = 0
    a, b, c = 1 - float(share @ share), left - float(start @ share), left**2 - float(start @ start)
    if b <= 0:
        return 0.0
    return min(max(c / (b + math.sqrt(max(b * b - a * c, 0.0))), 0.0), most)


def _cut(ends: Vector, shares: Vector, normal: float) -> tuple[Vector, Vector]:
    """What is left of the rings when the contact shrinks to ``normal``."""
    count = int(np.searchsorted(ends, normal))
    if count >= len(ends):
        return ends, shares
    return np.append(ends[:count], normal), shares[: count + 1]


def _short(ends: Vector, shares: Vector) -> tuple[Vector, Vector]:
    """Rings that slipped the same way are one ring, and there are no more than MEMORY of them."""
    differ = np.append(np.abs(np.diff(shares, axis=0)).max(axis=1) > 1e-12, True)
    ends, shares = ends[differ], shares[differ]
    while len(ends) > MEMORY:  # the two innermost rings become one that carries the same
        both = (ends[0] * shares[0] + (ends[1] - ends[0]) * shares[1]) / ends[1]
        ends, shares = ends[1:], np.vstack([both, shares[2:]])
    return ends, shares
