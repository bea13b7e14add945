"""Whether a contact slides, compiled: each taxel's share of the shear, and whether the pull grows no more."""

import math

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.events.signals.step_numba import binary

BORNE = 0.2
"""Taxels that bear less than this part of what the most pressed one does count by how much of it they bear."""
LIGHT = 0.02
"""Least part of what the most pressed one does that a taxel of the rim bears."""
KNOWN = 0.12
"""Largest sigma of a share that is asked for."""
ALONE = 0.04
"""A share less well known is that of the 3 x 3 taxels around."""
EDGE_KNOWN, EDGE_SIGMAS = 0.08, 2.0
"""Largest sigma of the share of the edge, all that bears less than `BORNE`; less so many sigma it may be the rim's."""
FULL, STUCK, SIGMAS = 0.1, 0.18, 3.0
"""A share is full at less than so much below 1, and sticks at more, or at so many sigma; full at half as many."""
CERTAIN = 4.5
"""Sigmas from which on a taxel is said to stick: in a contact that vibrates for a second noise passes 3 somewhere."""
LITTLE, MUCH = 0.1, 0.15
"""Parts of the load: a contact sticks where taxels that stick bear so much, until they bear less than so little."""
MEMORY = 0.5
"""[s] over which the fastest growth is remembered."""
SURE = 6.0
"""Growth counts from so many sigma on."""
CLEAR = 0.1
"""Noise of the growth over the fastest one, at most: a pull that goes on is seven times that above one that yields."""
GROWN = 0.1
"""Part of the present ratio by which it must have grown, above its least of late ..."""
LATE = 2.0
"""... which is forgotten with this time constant [s]."""
YIELDS, GOES_ON = 0.25, 0.4
"""The pull yields where it grows by less than this part of the fastest, until it grows by more than that.

Where an object is moved evenly the growth falls as the root of the way that is left (Mindlin): less is nearer the slip.
"""
LONGER, STOPPED = 4.0, 2.7
"""A mean so many times as long still grows, when the pull yields, by (1 + x) exp(-x) of the fastest growth after a
sudden stop, x its `STOPPED` means ago over how much longer; ..."""
SOFT, AT_ONCE = 0.7, 0.95
"""... by less than this part of that the pull has become slow by and by, by more than that it has stopped at once."""
FINE, SUDDEN = 0.05, 0.4
"""Where the growth has fallen below that part of the fastest by and by, it is asked of a longer mean, of less noise."""


@kept_njit(error_model="numpy")
def slide(values, fast, use, sigma, noise_q, noise_n, dt, interval, taus, kept, rising, planes, levels):  # type: ignore[no-untyped-def]
    """Take one frame (rows, cols, 3) and its means ``fast``; write the share (rows, cols) into ``planes`` and whether
    the pull yields and whether the contact sticks into ``levels``, in CNN values.

    ``sigma`` (rows, cols) of shear from frame to frame, ``noise_q``, ``noise_n`` of shear and normal after the mean;
    ``taus`` (n,) [s] time constants tried, at least the ``interval`` of the frames; ``rising``: the load still rises.
    ``kept`` (2 n + 4,): the ratio of the whole shear to the whole normal load after one mean and after two of each
    time constant, its fastest growth of late [1/s], its least of late, its fastest growth in all of the pull, and the
    time constant that was looked at, less where the growth had become slow by and by: then it came less late.
    """
    rows, cols = use.shape
    most = force = q = r = q_now = r_now = whole = noise = fw = 0.0
    for i in range(rows):
        for j in range(cols):
            planes[5, i, j] = 0.0
            if use[i, j]:
                most = max(most, fast[i, j, 2])
                whole += noise_n[i, j] ** 2
    for i in range(rows):
        for j in range(cols):
            if use[i, j] and fast[i, j, 2] > 0:
                weight = min(fast[i, j, 2] / (BORNE * most), 1.0)
                force += weight * fast[i, j, 2]
                q += weight * fast[i, j, 0]
                r += weight * fast[i, j, 1]
                weight = fast[i, j, 2] / most
                fw += weight * fast[i, j, 2]
                q_now += weight * values[i, j, 0]
                r_now += weight * values[i, j, 1]
                noise += (weight * sigma[i, j]) ** 2
    levels[9] = levels[10] = 0.0
    shear = math.hypot(q, r)
    if not (force > 3 * math.sqrt(whole) and shear > 0 and math.isfinite(q_now + r_now)):
        kept[:] = 0.0
        return
    ratio = shear / force
    x, y = q / shear, r / shear
    rim, of_rim = _rim(fast, use, noise_q, noise_n, x, y, ratio, most)
    bears = 0.0
    for i in range(rows):
        for j in range(cols):
            if not use[i, j] or not fast[i, j, 2] > BORNE * most:
                continue
            press = fast[i, j, 2]
            along = fast[i, j, 0] * x + fast[i, j, 1] * y
            doubt = math.hypot(noise_q[i, j], rim * noise_n[i, j]) / (rim * press)
            if doubt > ALONE:
                press = along = spread = 0.0
                for k in range(max(i - 1, 0), min(i + 2, rows)):
                    for m in range(max(j - 1, 0), min(j + 2, cols)):
                        if use[k, m]:
                            press += fast[k, m, 2]
                            along += fast[k, m, 0] * x + fast[k, m, 1] * y
                            spread += noise_q[k, m] ** 2 + (rim * noise_n[k, m]) ** 2
                doubt = math.sqrt(spread) / (rim * press) if press > 0 else 1.0
            doubt = math.hypot(doubt, of_rim)
            if doubt < KNOWN:  # the share is known well enough to be asked for
                lack = 1 - along / (rim * press)
                full, stuck = max(FULL, SIGMAS / 2 * doubt), max(STUCK, SIGMAS * doubt)
                # stuck is -1/4 and below, full 1/4 and above; one that has stuck is remembered, so it is to be certain
                certain = max(STUCK, CERTAIN * doubt)
                planes[5, i, j] = max(-1.0, min(1.0, 0.25 - 0.5 * (lack - full) / (certain - full)))
                bears += fast[i, j, 2] * max(0.0, min(1.0, (lack - full) / (stuck - full)))
    levels[10] = binary(bears / force, LITTLE, MUCH)
    now = (q_now * x + r_now * y) / fw
    _grow(now, math.sqrt(noise) / fw, dt, interval, taus, kept, rising, levels)


@kept_helper(error_model="numpy")
def _rim(fast, use, noise_q, noise_n, x, y, ratio, most):  # type: ignore[no-untyped-def]
    """Return the ratio of shear to pressing that the rim of the contact carries, and its sigma over itself.

    It is that of the taxels above the ``ratio`` of all; or, where that is surely more, that of the edge: a contact
    little wider than two taxels has its core on all that bear much, and there these carry the same below friction.
    """
    rows, cols = use.shape
    above = below = spread = edge = light = doubt = 0.0
    for i in range(rows):
        for j in range(cols):
            press = fast[i, j, 2]
            if not use[i, j] or not press > LIGHT * most:
                continue
            along = fast[i, j, 0] * x + fast[i, j, 1] * y
            noise = noise_q[i, j] ** 2 + (ratio * noise_n[i, j]) ** 2
            # one that bears little is part of the rim all the same where it is well known
            if along > ratio * press and (press > BORNE * most or (ALONE * ratio * press) ** 2 > noise):
                above += along
                below += press
                spread += noise
            if press < BORNE * most and press > SIGMAS * noise_n[i, j]:
                edge += along
                light += press
                doubt += noise
    rim = max(above / below, ratio) if below > 0 else ratio
    spread = math.sqrt(spread) / (rim * below) if below > 0 else 0.0  # those above are so by noise, too
    if edge > 0:
        doubt = math.sqrt(doubt) / edge
        if doubt < EDGE_KNOWN and edge / light * (1 - EDGE_SIGMAS * doubt) > rim:
            return edge / light * (1 - EDGE_SIGMAS * doubt), doubt
    return rim, spread


@kept_helper(error_model="numpy")
def _grow(now, noise, dt, interval, taus, kept, rising, levels):  # type: ignore[no-untyped-def]
    """Follow the growth of the ratio ``now`` of shear to normal load, whose white noise is ``noise``."""
    count = len(taus)
    if rising:  # how shear grows while a grip closes says nothing of a pull
        kept[: 2 * count] = now
        kept[2 * count] = 0.0
        kept[2 * count + 1] = now
        kept[2 * count + 2] = 0.0
        return
    fastest = kept[2 * count] * math.exp(-dt / MEMORY)
    for k in range(count):
        tau = max(taus[k], interval)
        # the mean interval: devices sample evenly, and a frame that came late would look like a pull that halts
        a = 1 - math.exp(-interval / tau)
        kept[k] += a * (now - kept[k])
        kept[count + k] += a * (kept[k] - kept[count + k])
        growth = (kept[k] - kept[count + k]) / tau
        if growth > SURE * 0.5 * noise * math.sqrt(interval / tau**3):
            fastest = max(fastest, growth)
    kept[2 * count] = fastest
    kept[2 * count + 2] = max(fastest, kept[2 * count + 2] * math.exp(-dt / LATE))
    for k in range(count):  # the shortest that noise allows
        tau = max(taus[k], interval)
        if fastest > 0 and 0.5 * noise * math.sqrt(interval / tau**3) < CLEAR * fastest:
            growth = (kept[k] - kept[count + k]) / tau
            least = kept[2 * count + 1] + (1 - math.exp(-dt / LATE)) * (kept[k] - kept[2 * count + 1])
            kept[2 * count + 1] = min(least, kept[k])
            kept[2 * count + 3] = tau * _at_once(tau, kept[2 * count + 2], interval, taus, kept)
            if kept[k] - least < GROWN * kept[k] or _goes_on(fastest, noise, interval, taus, kept):
                return
            levels[9] = binary(1 - growth / fastest, 1 - GOES_ON, 1 - YIELDS)
            return


@kept_helper(error_model="numpy")
def _at_once(tau, most, interval, taus, kept):  # type: ignore[no-untyped-def]
    """Return 1 where the growth has just been as fast as ever, ``most``; 0 where it has become slow by and by."""
    count = len(taus)
    k = 0
    while k < count - 1 and taus[k] < LONGER * tau:
        k += 1
    longer = max(taus[k], interval)
    growth, x = (kept[k] - kept[count + k]) / longer, STOPPED * tau / longer
    left = growth / (most * (1 + x) * math.exp(-x))
    return max(0.0, min(1.0, (left - SOFT) / (AT_ONCE - SOFT)))


@kept_helper(error_model="numpy")
def _goes_on(fastest, noise, interval, taus, kept):  # type: ignore[no-untyped-def]
    """Return whether a growth that has become slow by and by goes on: what noise hides from a short mean."""
    count = len(taus)
    for k in range(count):
        tau = max(taus[k], interval)
        if 0.5 * noise * math.sqrt(interval / tau**3) < FINE * fastest:
            growth = (kept[k] - kept[count + k]) / tau
            return YIELDS * fastest < growth < SUDDEN * fastest
    return False
