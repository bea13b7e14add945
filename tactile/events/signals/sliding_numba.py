"""Slip of a contact, compiled: share of each taxel in the shear, and whether the pull stops growing."""

import math

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.events.signals.step_numba import binary

BORNE = 0.2
"""Part of the largest pressing of a taxel, below which a taxel counts with reduced weight."""
LIGHT = 0.02
"""Least pressing of a rim taxel, as a part of the largest pressing."""
KNOWN = 0.12
"""Largest sigma of a share that is used."""
ALONE = 0.04
"""Sigma above which the share of the 3 x 3 neighbourhood is used."""
EDGE_KNOWN, EDGE_SIGMAS = 0.08, 2.0
"""Largest relative sigma of the ratio of the edge (taxels below `BORNE`), and the sigmas subtracted from it."""
FULL, STUCK, SIGMAS = 0.1, 0.18, 3.0
"""Lack of share below which a taxel is full and above which it sticks, at least SIGMAS / 2 and SIGMAS of its noise."""
CERTAIN = 4.5
"""Sigmas for a sticking taxel in ``share``: a vibrating contact passes 3 sigma somewhere within a second."""
LITTLE, MUCH = 0.1, 0.15
"""Parts of the load on sticking taxels at which ``sticking`` goes off and on."""
MEMORY = 0.5
"""[s] Memory of the fastest growth."""
SURE = 6.0
"""Least growth [sigma]."""
CLEAR = 0.1
"""Largest noise of the growth over the fastest growth."""
GROWN = 0.1
"""Least growth of the ratio above its recent minimum, as a part of the ratio."""
LATE = 2.0
"""[s] Memory of the recent minimum."""
YIELDS, GOES_ON = 0.25, 0.4
"""Growth over the fastest growth, below which ``yielding`` goes on and above which it goes off.

Under an even motion the growth falls with the root of the remaining distance (Mindlin), so a lower value is closer to
the slip.
"""
LONGER, STOPPED = 4.0, 2.7
"""A filter LONGER times as long still grows by (1 + x) exp(-x) of the fastest growth, STOPPED time constants after a
sudden stop; x is STOPPED / LONGER."""
SOFT, AT_ONCE = 0.7, 0.95
"""Measured over expected growth: below SOFT the pull slowed gradually, above AT_ONCE it stopped suddenly."""
FINE, SUDDEN = 0.05, 0.4
"""Noise and growth over the fastest growth, at which a longer filter decides whether a slow growth continues."""


@kept_njit(error_model="numpy")
def slide(values, fast, use, sigma, noise_q, noise_n, dt, interval, taus, kept, rising, planes, levels):  # type: ignore[no-untyped-def]
    """Process one frame (rows, cols, 3) with its means ``fast``; write the share, ``yielding`` and ``sticking``.

    ``sigma`` (rows, cols): frame-to-frame noise of shear; ``noise_q``, ``noise_n``: noise of shear and normal after the
    mean; ``taus`` (n,) [s]: time constants, at least the ``interval`` of the frames; ``rising``: the load still rises.
    ``kept`` (2 n + 4,): ratio of total shear to total normal load after one and after two filters of each time
    constant, its fastest recent growth [1/s], its recent minimum, its fastest growth during the pull, and the time
    constant in use, reduced where the growth became slow gradually.
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
            if doubt < KNOWN:  # the share is known well enough
                lack = 1 - along / (rim * press)
                full, stuck = max(FULL, SIGMAS / 2 * doubt), max(STUCK, SIGMAS * doubt)
                # stuck: -1/4 and below, full: 1/4 and above; sticking is remembered, so it needs certainty
                certain = max(STUCK, CERTAIN * doubt)
                planes[5, i, j] = max(-1.0, min(1.0, 0.25 - 0.5 * (lack - full) / (certain - full)))
                bears += fast[i, j, 2] * max(0.0, min(1.0, (lack - full) / (stuck - full)))
    levels[10] = binary(bears / force, LITTLE, MUCH)
    now = (q_now * x + r_now * y) / fw
    _grow(now, math.sqrt(noise) / fw, dt, interval, taus, kept, rising, levels)


@kept_helper(error_model="numpy")
def _rim(fast, use, noise_q, noise_n, x, y, ratio, most):  # type: ignore[no-untyped-def]
    """Return the ratio of shear to pressing at the rim of the contact, and its relative sigma.

    It is that of the taxels above the ``ratio`` of all, or that of the edge, where that is larger with certainty. In a
    contact little wider than two taxels the core lies on all well-pressed taxels, and these carry the same below
    friction.
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
            # a lightly pressed taxel belongs to the rim where its ratio is well known
            if along > ratio * press and (press > BORNE * most or (ALONE * ratio * press) ** 2 > noise):
                above += along
                below += press
                spread += noise
            if press < BORNE * most and press > SIGMAS * noise_n[i, j]:
                edge += along
                light += press
                doubt += noise
    rim = max(above / below, ratio) if below > 0 else ratio
    spread = math.sqrt(spread) / (rim * below) if below > 0 else 0.0  # noise selects them, too
    if edge > 0:
        doubt = math.sqrt(doubt) / edge
        if doubt < EDGE_KNOWN and edge / light * (1 - EDGE_SIGMAS * doubt) > rim:
            return edge / light * (1 - EDGE_SIGMAS * doubt), doubt
    return rim, spread


@kept_helper(error_model="numpy")
def _grow(now, noise, dt, interval, taus, kept, rising, levels):  # type: ignore[no-untyped-def]
    """Update the growth of the ratio ``now`` of shear to normal load, with white noise ``noise``."""
    count = len(taus)
    if rising:  # shear of a closing grip is not a pull
        kept[: 2 * count] = now
        kept[2 * count] = 0.0
        kept[2 * count + 1] = now
        kept[2 * count + 2] = 0.0
        return
    fastest = kept[2 * count] * math.exp(-dt / MEMORY)
    for k in range(count):
        tau = max(taus[k], interval)
        # the mean interval: a late frame would look like a pause of the pull
        a = 1 - math.exp(-interval / tau)
        kept[k] += a * (now - kept[k])
        kept[count + k] += a * (kept[k] - kept[count + k])
        growth = (kept[k] - kept[count + k]) / tau
        if growth > SURE * 0.5 * noise * math.sqrt(interval / tau**3):
            fastest = max(fastest, growth)
    kept[2 * count] = fastest
    kept[2 * count + 2] = max(fastest, kept[2 * count + 2] * math.exp(-dt / LATE))
    for k in range(count):  # the shortest filter that noise allows
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
    """Return 1 after a sudden stop of a growth of ``most``, 0 after a gradual one, a value between otherwise."""
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
    """Return whether a growth that became slow gradually continues, which noise hides from a short mean."""
    count = len(taus)
    for k in range(count):
        tau = max(taus[k], interval)
        if 0.5 * noise * math.sqrt(interval / tau**3) < FINE * fastest:
            growth = (kept[k] - kept[count + k]) / tau
            return YIELDS * fastest < growth < SUDDEN * fastest
    return False
