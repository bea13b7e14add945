"""Partial slip of a round contact, compiled: one load after another, or many from known states."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

MEMORY = 12
"""Most rings of a state; beyond that the neighbours are merged whose traction changes least."""
ALIKE = 1e-9
"""Largest difference of the shares of two rings that are merged: the rounding of many small steps."""
ROOM = MEMORY + 2
"""Rings in the arrays: one step adds at most two before they are merged."""


@kept_helper(error_model="numpy")
def _merged(ends, shares, count):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Merge rings with equal shares, then the most similar ones down to MEMORY; return their number."""
    kept = 0
    for k in range(count):
        last = k == count - 1
        if last or max(abs(shares[k + 1, 0] - shares[k, 0]), abs(shares[k + 1, 1] - shares[k, 1])) > ALIKE:
            ends[kept], shares[kept, 0], shares[kept, 1] = ends[k], shares[k, 0], shares[k, 1]
            kept += 1
    while kept > MEMORY:  # keeps the force of both
        best, least, low = 1, np.inf, 0.0
        for k in range(1, kept):
            inner, outer = ends[k - 1] - low, ends[k] - ends[k - 1]
            apart = math.hypot(shares[k, 0] - shares[k - 1, 0], shares[k, 1] - shares[k - 1, 1])
            if apart * min(inner, outer) < least:
                best, least = k, apart * min(inner, outer)
            low = ends[k - 1]
        low = ends[best - 2] if best > 1 else 0.0
        inner = (ends[best - 1] - low) / (ends[best] - low)
        for axis in range(2):
            shares[best, axis] = inner * shares[best - 1, axis] + (1 - inner) * shares[best, axis]
        for k in range(best, kept):
            ends[k - 1], shares[k - 1, 0], shares[k - 1, 1] = ends[k], shares[k, 0], shares[k, 1]
        kept -= 1
    return kept


@kept_njit(error_model="numpy")
def step(mu, ends, shares, count, normal, pull_x, pull_y):  # type: ignore[no-untyped-def]  # the same
    """Load a contact as ``friction.load_to``, its rings in place: (rings, force of the stuck circle, sliding)."""
    size = math.hypot(pull_x, pull_y)
    if normal <= 0 or mu == 0:
        return 0, 0.0, size > 0
    if size >= mu * normal:
        ends[0], shares[0, 0], shares[0, 1] = normal, pull_x / size, pull_y / size
        return 1, 0.0, True
    # remove rings outside a shrunken contact
    n = 0
    while n < count and ends[n] < normal:
        n += 1
    if n < count:
        ends[n], count = normal, n + 1
    wanted_x, wanted_y, inner = pull_x / mu, pull_y / mu, 0.0
    residual_x, residual_y = wanted_x, wanted_y
    for k in range(count):
        residual_x -= (ends[k] - inner) * shares[k, 0]
        residual_y -= (ends[k] - inner) * shares[k, 1]
        inner = ends[k]
    grown = normal - inner
    if math.hypot(residual_x, residual_y) <= grown:
        if grown > 0:
            ends[count], shares[count, 0], shares[count, 1] = normal, residual_x / grown, residual_y / grown
            count += 1
        return _merged(ends, shares, count), normal, False
    # |wanted - carried by the circle c| = normal - c; the ring from c out takes the full share. The difference
    # rises with c because shares are at most 1, so walking in from the rim finds the largest c first.
    for back in range(count):
        k = count - 1 - back
        low = ends[k - 1] if k > 0 else 0.0
        share_x, share_y, most = shares[k, 0], shares[k, 1], ends[k] - low
        residual_x += most * share_x
        residual_y += most * share_y
        left = normal - low
        if math.hypot(residual_x, residual_y) <= left:
            # squared: (1 - |share|^2) s^2 - 2 (left - rest . share) s + left^2 - |rest|^2 = 0, s in 0 .. most
            a = 1 - (share_x * share_x + share_y * share_y)
            b = left - (residual_x * share_x + residual_y * share_y)
            c = left * left - (residual_x * residual_x + residual_y * residual_y)
            s = 0.0 if b <= 0 else min(max(c / (b + math.sqrt(max(b * b - a * c, 0.0))), 0.0), most)
            residual_x -= s * share_x
            residual_y -= s * share_y
            length = max(math.hypot(residual_x, residual_y), 1e-300)
            if s > 0:
                ends[k] = low + s
                k += 1
            ends[k], shares[k, 0], shares[k, 1] = normal, residual_x / length, residual_y / length
            return _merged(ends, shares, k + 1), low + s, False
    ends[0], shares[0, 0], shares[0, 1] = normal, pull_x / size, pull_y / size
    return 1, 0.0, True


@kept_njit(error_model="numpy")
def steps(mu, known_ends, known_shares, known_counts, which, loads, ends, shares, counts):  # type: ignore[no-untyped-def]  # the same
    """One step from a known state for each load (n, 3), rows (Q, R, F): rings (n, ROOM), their counts (n,)."""
    for n in range(len(loads)):
        k = which[n]
        for ring in range(known_counts[k]):
            ends[n, ring] = known_ends[k, ring]
            shares[n, ring, 0], shares[n, ring, 1] = known_shares[k, ring, 0], known_shares[k, ring, 1]
        counts[n], _, _ = step(mu, ends[n], shares[n], known_counts[k], loads[n, 2], loads[n, 0], loads[n, 1])
        for ring in range(counts[n], ROOM):
            ends[n, ring] = shares[n, ring, 0] = shares[n, ring, 1] = 0.0


def rooms(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return arrays (ends, shares) for the rings of ``count`` states."""
    return np.zeros((count, ROOM)), np.zeros((count, ROOM, 2))
