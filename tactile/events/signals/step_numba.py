"""Update of the signals of a finger for one frame, compiled; `Signals` has the formulas."""

import math

from cnnsim.support.compiled_loops import kept_njit

CROSS = 0.02
"""Shear below this part of the normal component has no direction: cross-talk of the axes of real taxels."""
WHOLE, WHOLE_PART = 6.0, 0.03
"""Threshold of an unexplained change of the total shear [sigma], and as a part of the load."""
OUTRUNS = 1.25
"""It must exceed its own recent mean by this factor."""
CREEP, CREEP_TIME = 0.3, 0.4
"""It must exceed this part of the largest recent change (creep of silicone), remembered for this time [s]."""
GROWS = 1.25
"""No creep is assumed where the change of shear exceeds its recent mean square by this factor."""
HELD = 0.24
"""CNN value between off and on: the state of the comparator stays."""
MOVED = 6.0
"""Squared change of shear over its noise variance, above which it is no noise."""


@kept_njit(error_model="numpy")
def binary(value, off, on):  # type: ignore[no-untyped-def]  # typed at the call
    """Return a CNN value: 1/6 at ``off``, 1/4 at ``on``, linear between, then 1/4 per ``on`` up to 1."""
    size = abs(value)
    if size >= on:
        out = min(0.25 * size / on, 1.0) if on > 0 else 1.0
    elif size > off:
        out = 1 / 6 + (size - off) / (on - off) / 12
    else:
        out = size / (6 * off) if off > 0 else 0.0
    return out if value >= 0 else -out


@kept_njit(error_model="numpy")
def quiet(planes, sources, factors, low, high):  # type: ignore[no-untyped-def]
    """Return whether every signal, plane ``sources[n]`` times ``factors[n]``, lies between ``low`` and ``high``."""
    count, rows, cols = low.shape
    for n in range(count):
        plane, factor = planes[sources[n]], factors[n]
        for i in range(rows):
            for j in range(cols):
                value = plane[i, j] * factor
                if not (low[n, i, j] < value < high[n, i, j]):
                    return False
    return True


@kept_njit(error_model="numpy")
def step(  # type: ignore[no-untyped-def]  # typed at the call
    values, use, counts, inward, rectify, dt, off, on, drawn_on, noise_q, noise_n, fast, slow, scalars, taps, planes,
    levels,
):  # fmt: skip
    """Process one frame (rows, cols, 3); write ``planes`` (7, rows, cols) and ``levels``, except share and slip.

    ``use`` (rows, cols) marks valid taxels, ``counts`` those not left out; ``off``, ``on`` (rows, cols, 3) thresholds;
    ``drawn_on`` (rows, cols) threshold of an unexplained change of shear; ``noise_q``, ``noise_n`` noise of shear and
    normal after 10 ms; ``taps`` the time constants [s], and the factor of the held load. State: means
    ``fast``, ``slow`` (rows, cols, 3),
    ``scalars``: F after 4, 15 and 100 ms, held load, its noise, Q and R after 10 ms, number of frames, changes of
    shear and of pressing, largest recent unsteadiness, mean of the total unexplained change (2), largest recent change
    of the total shear, mean of the changes of shear.
    """
    rows, cols = use.shape
    a_fast = 1 - math.exp(-dt / max(taps[0], 2 * dt)) if dt > 0 else 0.0
    sheared = scalars[8] > 0.25 * scalars[9]
    sets_in = sheared and scalars[8] > GROWS * scalars[15]
    # while the load changes the slow mean must keep up
    a_slow = 1 - math.exp(-dt / (taps[7] if scalars[10] > 1 and not sheared else taps[1]))
    first = scalars[7] == 0
    force = q = r = n = q_slow = r_slow = n_slow = press_noise = shear_noise = squares = 0.0
    for i in range(rows):
        for j in range(cols):
            for k in range(3):
                value = values[i, j, k] * (inward if k == 2 else 1.0)
                if not (use[i, j] and math.isfinite(value)):
                    value = fast[i, j, k]
                if first:
                    fast[i, j, k] = slow[i, j, k] = value
                fast[i, j, k] += a_fast * (value - fast[i, j, k])
                slow[i, j, k] += a_slow * (value - slow[i, j, k])
                # cross-talk of a strong pressing
                extra = 0.0 if k == 2 else CROSS * max(fast[i, j, 2], 0.0)
                low = max(off[i, j, k], extra)
                shown = fast[i, j, k] if k < 2 else value
                planes[k, i, j] = binary(shown, low, low + max(on[i, j, k] - off[i, j, k], extra)) if use[i, j] else 0.0
                if k == 2 and counts[i, j]:  # an invalid taxel keeps its last value
                    force += max(value, 0.0) if rectify else value
            low, high = off[i, j, 2], on[i, j, 2]
            firm = max(binary(slow[i, j, 2], 3 * low, 3 * high), binary(fast[i, j, 2], 5 * low, 5 * high))
            planes[6, i, j] = firm if use[i, j] else 0.0
            if use[i, j]:
                q += fast[i, j, 0]
                r += fast[i, j, 1]
                q_slow += slow[i, j, 0]
                r_slow += slow[i, j, 1]
                n += fast[i, j, 2]
                n_slow += slow[i, j, 2]
                shear_noise += noise_q[i, j] ** 2
                squares += fast[i, j, 2] ** 2
            if counts[i, j]:
                press_noise += noise_n[i, j] ** 2
    f4, f15, f100, held, seen = scalars[0], scalars[1], scalars[2], scalars[3], scalars[7]
    if first:
        f4 = f15 = f100 = held = force
    f4 += (1 - math.exp(-dt / taps[2])) * (force - f4)
    f15 += (1 - math.exp(-dt / taps[3])) * (force - f15)
    f100 += (1 - math.exp(-dt / taps[4])) * (force - f100)
    held += taps[5] * (force - held)
    fall = f15 - f4
    scalars[0], scalars[1], scalars[2], scalars[3] = f4, f15, f100, held
    scalars[5], scalars[6], scalars[7] = q, r, seen + 1
    noise = 3 * math.sqrt(press_noise) + 1e-12
    top, scalars[4] = max(held, noise), noise
    levels[0] = binary(f4, 2 * noise, 3 * noise)
    levels[1] = binary(f4 - f100, 0.15 * max(f100, 0.0) + noise, 0.25 * max(f100, 0.0) + 1.5 * noise)
    levels[2] = binary(fall, 0.01 * top + noise / 3, 0.015 * top + noise / 2)
    away = abs(f4 - f100) / (0.04 * max(f100, 0.0) + 0.75 * noise)
    scalars[10] = max(min(away, 4.0), scalars[10] * math.exp(-dt / taps[6]))
    levels[5] = binary(scalars[10], 1.0, 1.5)
    driven = math.hypot(q - q_slow, r - r_slow)
    least = max(6 * math.sqrt(shear_noise), 0.004 * max(f100, 0.0), 1e-12)
    levels[7] = binary(driven, least / 1.5, least)
    levels[8] = binary(fall, 0.027 * top + noise / 3, 0.04 * top + noise / 2)
    # averaging over the taxels reveals a pull below the noise of each
    explained = (n - n_slow) / n_slow if n_slow > 3 * math.sqrt(press_noise) and not sets_in else 0.0
    all_q, all_r = q - q_slow * (1 + explained), r - r_slow * (1 + explained)
    scalars[14] = max(driven, scalars[14] * math.exp(-dt / CREEP_TIME))
    least_all = max(WHOLE * math.sqrt(shear_noise), WHOLE_PART * max(f100, 0.0), CREEP * scalars[14], 1e-12)
    # creep after the closing of a grip slows down; a new pull exceeds its mean
    change_all, most = math.hypot(all_q, all_r), max(abs(all_q), abs(all_r))
    level = binary(change_all, least_all / 1.5, least_all)
    if not change_all > OUTRUNS * math.hypot(scalars[12], scalars[13]):
        level = min(level, HELD)
    whole_q = math.copysign(level, all_q) if 2 * abs(all_q) > most else 0.0
    whole_r = math.copysign(level, all_r) if 2 * abs(all_r) > most else 0.0
    scalars[12] += a_slow * (all_q - scalars[12])
    scalars[13] += a_slow * (all_r - scalars[13])
    moved = pressed = 0.0
    typical = squares / f100 if f100 > 0 else 0.0  # mean pressing of a taxel, weighted by itself
    for i in range(rows):
        for j in range(cols):
            change_n = fast[i, j, 2] - slow[i, j, 2]
            under = max(slow[i, j, 2], 0.0)
            creep = 0.0  # no creep where the change is mostly shear and grows
            if n_slow > 0 and rows * cols > 1 and not sets_in:
                creep = CREEP * scalars[14] * min(under / n_slow, 1.0)
            least = max(drawn_on[i, j], 0.016 * typical, creep)
            for k in range(2):
                change = fast[i, j, k] - slow[i, j, k]
                part = slow[i, j, k] / under if under > 3 * on[i, j, 2] and not sets_in else 0.0
                change -= part * change_n
                own = binary(change, least / 1.5, least)
                if rows * cols > 1 and abs(own) < 0.25 and planes[2, i, j] > 0.25:
                    whole = whole_q if k == 0 else whole_r
                    if abs(whole) > abs(own):
                        own = whole
                planes[3 + k, i, j] = own if use[i, j] else 0.0
                if use[i, j]:
                    moved += change * change
            if use[i, j]:
                pressed += change_n * change_n
    calm = 1 - math.exp(-dt / taps[6])
    scalars[8] += calm * (moved - scalars[8])
    scalars[9] += calm * (pressed - scalars[9])
    scalars[15] += (1 - math.exp(-dt / taps[1])) * (scalars[8] - scalars[15])
    still = MOVED * shear_noise  # in a still hold both are noise, and their ratio is meaningless
    levels[13] = binary(scalars[8], 0.2 * scalars[9] + still / 1.5, 0.3 * scalars[9] + still) if scalars[8] > 0 else 0.0
    levels[14] = binary(scalars[8], 0.2 * scalars[9], 0.3 * scalars[9]) if scalars[8] > 0 else 0.0
