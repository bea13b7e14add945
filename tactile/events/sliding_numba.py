"""Whether a contact slides, compiled: each taxel's share of the shear, and whether the pull grows no more."""

import math

from numba import njit

from tactile.events.signals_numba import binary

BORNE = 0.1
"""Taxels that bear less than this part of what the most pressed one does are not asked."""
MEMORY = 0.5
"""[s] over which the fastest growth is remembered."""
SURE = 6.0
"""Growth counts from so many sigma on."""
CLEAR = 0.07
"""Noise of the growth over the fastest one, at most: a third of what it is compared with."""
YIELDS, GOES_ON = 0.23, 0.35
"""The pull yields where it grows by less than this part of the fastest, until it grows by more than that."""


@njit(cache=True, error_model="numpy")
def slide(values, fast, use, sigma, noise_q, noise_n, dt, interval, taus, kept, rising, planes, levels):  # type: ignore[no-untyped-def]
    """Take one frame (rows, cols, 3) and its means ``fast``; write the share (rows, cols) into ``planes`` and whether
    the pull yields into ``levels``, in CNN values.

    ``sigma`` (rows, cols) of shear from frame to frame, ``noise_q``, ``noise_n`` of shear and normal after the mean;
    ``taus`` (n,) [s] time constants tried, at least the ``interval`` of the frames; ``rising``: the load still rises.
    ``kept`` (2 n + 1,): the ratio of the whole shear to the whole normal load after one mean and after two of each
    time constant, and its fastest growth of late [1/s].
    """
    rows, cols = use.shape
    count = len(taus)
    most = force = q = r = q_now = r_now = 0.0
    for i in range(rows):
        for j in range(cols):
            if use[i, j]:
                most = max(most, fast[i, j, 2])
    noise = 0.0
    whole = 0.0
    for i in range(rows):
        for j in range(cols):
            planes[5, i, j] = 0.0
            if use[i, j]:
                whole += noise_n[i, j] ** 2
                if fast[i, j, 2] > BORNE * most:
                    force += fast[i, j, 2]
                    q += fast[i, j, 0]
                    r += fast[i, j, 1]
                    q_now += values[i, j, 0]
                    r_now += values[i, j, 1]
                    noise += sigma[i, j] ** 2
    levels[9] = 0.0
    shear = math.hypot(q, r)
    if not (force > 3 * math.sqrt(whole) and shear > 0 and math.isfinite(q_now + r_now)):
        kept[:] = 0.0
        return
    ratio = shear / force
    for i in range(rows):
        for j in range(cols):
            press = fast[i, j, 2]
            if use[i, j] and press > BORNE * most:
                doubt = math.hypot(noise_q[i, j], ratio * noise_n[i, j]) / (ratio * press)
                if doubt < 0.12:  # the share is known well enough to be asked for
                    share = (fast[i, j, 0] * q + fast[i, j, 1] * r) / (shear * press * ratio)
                    # stuck is -1/4 and below, full 1/4 and above
                    planes[5, i, j] = max(-1.0, min(1.0, 0.25 + (share - 0.93) / 0.2))
    now = (q_now * q + r_now * r) / (shear * force)
    if rising:  # how shear grows while a grip closes says nothing of a pull
        kept[: 2 * count] = now
        kept[2 * count] = 0.0
        return
    noise = math.sqrt(noise) / force
    fastest = kept[2 * count] * math.exp(-dt / MEMORY)
    for k in range(count):
        tau = max(taus[k], interval)
        a = 1 - math.exp(-dt / tau)
        kept[k] += a * (now - kept[k])
        kept[count + k] += a * (kept[k] - kept[count + k])
        growth = (kept[k] - kept[count + k]) / tau
        if growth > SURE * 0.5 * noise * math.sqrt(interval / tau**3):
            fastest = max(fastest, growth)
    kept[2 * count] = fastest
    for k in range(count):  # the shortest that noise allows
        tau = max(taus[k], interval)
        if fastest > 0 and 0.5 * noise * math.sqrt(interval / tau**3) < CLEAR * fastest:
            growth = (kept[k] - kept[count + k]) / tau
            levels[9] = binary(1 - growth / fastest, 1 - GOES_ON, 1 - YIELDS)
            return
