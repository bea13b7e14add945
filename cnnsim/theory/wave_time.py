"""Switching times of trigger waves: cells change in one direction only, each triggered by neighbours that changed.

With a > 1 and neighbour weights A >= 0 the network is monotone: more black now is more black later (comparison
principle; Smith, "Monotone Dynamical Systems", AMS 1995). Take black as the colour that spreads. If every black cell
stays black, a white cell turns black as soon as its drive s from saturated neighbours exceeds a - 1, and then within

    T_sw = ln[(s - a - x_rest) / (s - a + 1)] + ln[(a - 1 + s) / (s - a + 1)] / (a - 1),

out of its saturation (it has rested at x_rest <= -1) and through the linear piece. Cells that no saturated pattern can
set off never change. So the outputs are final after the length of the longest path times T_sw. A white wave is a
black wave of the network with all signs turned.
"""

from typing import NamedTuple

import numpy as np

from cnnsim.network import Boundary, Template
from cnnsim.network.boundary import correlate
from cnnsim.support import Flags, Floats
from cnnsim.theory.neighbourhood import Pair, too_many, weighted_sums
from cnnsim.theory.wave_path import longest_path

_TIE = 1e-9


class Wave(NamedTuple):
    """The time of a wave [time constants] or None, and the reason."""

    time: float | None
    why: str


def switching_time(s: Floats, rest: Floats, a: float, step: float) -> Floats:
    """Return the longest time a cell takes from ``rest`` <= -1 to +1 under the drive ``s`` > a - 1.

    It is the larger of T_sw (see above) and the time of Euler steps of length ``step``, counted exactly.
    """
    goal = s - a
    out = np.log((goal - rest) / (goal + 1))
    exact = out + np.log((a - 1 + s) / (goal + 1)) / (a - 1)
    steps = np.ceil(out / -np.log1p(-step) - _TIE)
    x = goal + (rest - goal) * (1 - step) ** steps
    steps += np.ceil(np.log((a - 1 + s) / ((a - 1) * x + s)) / np.log1p((a - 1) * step) - _TIE)
    return np.maximum(exact, steps * step)


def wave_of_picture(
    template: Template, state: Floats, drive: Floats, masked: Flags, boundary: Boundary, step: float
) -> Wave:
    """Return the time of the wave from a black-and-white ``state`` with B*u + z + bias = ``drive``: (rows, cols).

    The wave is followed in generations: the cells that the black cells trigger, then the cells that these trigger.
    """
    refusal = _refusal(template, step)
    if refusal is None and not np.isin(state, (-1.0, 1.0)).all():
        refusal = "the initial state is not black and white"
    if refusal is not None:
        return Wave(None, refusal)
    black = _follow(template, state, drive, masked, boundary.y, boundary, step)
    return black if black.time is not None else _follow(template, -state, -drive, masked, -boundary.y, boundary, step)


def _follow(
    template: Template, state: Floats, drive: Floats, masked: Flags, outside: float, boundary: Boundary,
    step: float,
) -> Wave:  # fmt: skip
    a, y = template.self_feedback, state.copy()
    s = _neighbours(template, y, boundary, outside) + drive
    if ((y > 0) & ~masked & (s <= 1 - a + _TIE)).any():
        return Wave(None, "cells of both colours may change")
    rest, time, generations = np.minimum(-1.0, s - a), 0.0, 0
    while True:
        white = (y < 0) & ~masked
        if (white & (np.abs(s - a + 1) < _TIE)).any():
            return Wave(None, "a tie: a cell is driven exactly to the edge of switching")
        new = white & (s > a - 1)
        if not new.any():
            return Wave(time, f"a wave of {generations} generations, each within its switching time")
        time += float(switching_time(s[new], rest[new], a, step).max())
        generations += 1
        y[new] = 1.0
        s = _neighbours(template, y, boundary, outside) + drive


def worst_wave(
    template: Template, shape: tuple[int, int], boundary: Boundary, pairs: list[Pair], step: float, has_mask: bool
) -> Wave:
    """Return the time of the slowest wave on any black-and-white picture whose cells have these pairs (x(0), u)."""
    refusal = _refusal(template, step)
    if refusal is None and any(abs(x0) != 1 for x0, _ in pairs):
        refusal = "the initial state is not black and white"
    if refusal is not None:
        return Wave(None, refusal)
    black = _worst(template, shape, boundary, 1.0, pairs, step, has_mask)
    if black.time is not None:
        return black
    white = _worst(template, shape, boundary, -1.0, pairs, step, has_mask)
    return white if white.time is not None or "both" in black.why else black


def _worst(
    template: Template, shape: tuple[int, int], boundary: Boundary, sign: float, pairs: list[Pair], step: float,
    has_mask: bool,
) -> Wave:  # fmt: skip
    """`worst_wave` for one colour of the wave; ``sign`` -1 inverts the network, so that black always spreads."""
    a = template.self_feedback
    pairs = [(sign * x0, sign * u) for x0, u in pairs]
    outside = [(sign * y, sign * u) for y, u in boundary.constants]
    weights = _both_weights(template)
    b = weights.pop((0, 0))[1]
    first, later = [*pairs, *outside], [*pairs, *outside, *((1.0, u) for _, u in pairs)]
    at_first = weighted_sums([[(wa * y + wb * u,) for y, u in first] for wa, wb in weights.values()])
    at_work = weighted_sums([[(wa * y + wb * u, -wa + wb * u) for y, u in later] for wa, wb in weights.values()])
    alone = weighted_sums(
        [
            [*((-wa + wb * u, 2 * wa) for _, u in pairs), *((wa * y + wb * u, 0.0) for y, u in outside)]
            for wa, wb in weights.values()
        ]
    )
    if at_first is None or at_work is None or alone is None:
        return Wave(None, too_many(len(weights)))
    slowest, waiting = 0.0, [np.empty((0, 2))]
    for x0, u in set(pairs):
        own = b * u + sign * template.z
        if x0 > 0:
            if (at_first[:, 0] + own <= 1 - a + _TIE).any():
                return Wave(None, "cells of both colours may change, so it is no wave in one direction")
            continue
        s, rest = at_work[:, 0] + own, np.minimum(-1.0, at_work[:, 1] + own - a)
        if (np.abs(s - a + 1) < _TIE).any():
            return Wave(None, "a tie: a cell may be driven exactly to the edge of switching")
        on = s > a - 1
        slowest = max(slowest, float(switching_time(s[on], rest[on], a, step).max(initial=0.0)))
        waiting.append(alone + np.array([own - (a - 1), 0.0]))
    cells, path = longest_path(template, shape, boundary, np.concatenate(waiting), has_mask)
    colour = "black" if sign > 0 else "white"
    return Wave(cells * slowest, f"a {colour} wave: {cells} cells ({path}) of at most {slowest:.4g} each")


def _refusal(template: Template, step: float) -> str | None:
    if template.self_feedback <= 1:
        return "a <= 1: the outputs need not be black and white, and no contraction"
    if any(tap.weight < 0 for tap in template.feedback_taps):
        return "A has negative entries: neighbours do not only set each other off"
    return None if step <= 1 else "an Euler step above 1 does not keep the order of states"


def _neighbours(template: Template, y: Floats, boundary: Boundary, outside: float) -> Floats:
    """A*y without the cell itself."""
    taps = [tap for tap in template.feedback_taps if (tap.k, tap.l) != (0, 0)]
    return correlate(y, taps, boundary, outside, np.zeros_like(y))


def _both_weights(template: Template) -> dict[tuple[int, int], tuple[float, float]]:
    """Offset -> (entry of A, entry of B), the centre always among them."""
    both = {(0, 0): (template.self_feedback, 0.0)}
    for k, l, weight in template.feedback_taps:
        both[k, l] = (weight, 0.0)
    for k, l, weight in template.control_taps:
        both[k, l] = (both.get((k, l), (0.0, 0.0))[0], weight)
    return both
