"""Count chain: a rule of one weighted count, as templates of which each corrects the previous one.

Let f change its colour at t_1 < ... < t_n as the count k grows, white first and black last (n odd). The template with
drive k - (t_1 + t_n) / 2 and the weight (t_n - t_1) / 2 on its initial state g is white below t_1, black above t_n, and
g in between; with g = not h, where h has the changes t_2 ... t_(n-1), it is f. For even n the last change is made by
the logic unit, with one template more.
"""

from itertools import pairwise, product

import numpy as np

from cnnsim.prototyping.design.design import Design, DesignPart
from cnnsim.prototyping.design.linear import Norm, Separator, separate
from cnnsim.prototyping.design.rule import Signs, WindowRule, window_numbers

_MOST = 20_000


def count_chain(rule: WindowRule, norm: Norm = "sum") -> Design | None:
    """Return the shortest chain for a rule, or None if no count with small whole weights determines it."""
    if rule.with_state:
        return None  # the initial state is the chain's own means
    for counts, steps in _counts(rule):
        found = _built(rule, counts, steps, norm)
        if found is not None:
            return found
    return None


def _counts(rule: WindowRule) -> list[tuple[Signs, list[tuple[int, int]]]]:
    """Weighted counts (rows,) that determine the rule, fewest changes first, with their (count, colour) levels."""
    groups = _alike(rule)
    largest = 1
    while (2 * largest + 3) ** len(groups) <= _MOST and largest < 9:
        largest += 1
    sums = np.stack([rule.rows[:, group].sum(axis=1, dtype=np.int64) for group in groups], axis=1)
    found = []
    known = rule.table != 0
    for weights in product(range(-largest, largest + 1), repeat=len(groups)):
        if next((w for w in weights if w), 0) <= 0:
            continue  # one of each pair of opposite directions, and not zero
        k = sums @ np.array(weights)
        offset = -int(k.min())
        black = np.bincount(k[known & (rule.table > 0)] + offset, minlength=int(k.max()) + offset + 1) > 0
        white = np.bincount(k[known & (rule.table < 0)] + offset, minlength=int(k.max()) + offset + 1) > 0
        if (black & white).any():
            continue
        levels = [(int(i) - offset, 1 if black[i] else -1) for i in np.flatnonzero(black | white)]
        changes = sum(a[1] != b[1] for a, b in pairwise(levels))
        plain = sum(abs(w) + 0.5 * (w < 0) for w in weights)  # of equals, the count without minus signs
        found.append((changes, plain, k, levels))
    found.sort(key=lambda item: item[:2])
    return [(k, levels) for _, _, k, levels in found[:8]]


def _alike(rule: WindowRule) -> list[list[int]]:
    """Group the variables the rule depends on: two of a group can be exchanged and no answer changes."""
    groups: list[list[int]] = []
    for variable in rule.looks_at:
        for group in groups:
            order = np.arange(rule.rows.shape[1])
            order[[variable, group[0]]] = group[0], variable
            if np.array_equal(rule.table[window_numbers(rule.rows[:, order])], rule.table):
                group.append(variable)
                break
        else:
            groups.append([variable])
    return groups


def _built(rule: WindowRule, k: Signs, levels: list[tuple[int, int]], norm: Norm) -> Design | None:
    if levels[-1][1] < 0 and levels[0][1] > 0:
        k, levels = -k, [(-count, colour) for count, colour in reversed(levels)]
    changes = [(a[0] + b[0]) / 2 for a, b in pairwise(levels) if a[1] != b[1]]
    if len(changes) % 2 == 0:
        # white ... white: black after t_1 .. t_(n-1), and white again after t_n; black ... black turned round
        inner, last = changes[:-1], np.where(k > changes[-1], 1, -1).astype(np.int8)
        parts = _links(rule, k, inner, norm)
        final = separate(rule.rows, last, norm)
        if parts is None or not isinstance(final, Separator):
            return None
        colour = levels[0][1]  # f = chain xor last (white outside), or its negative
        if colour > 0:
            final = Separator(tuple(-w for w in final.weights), -final.bias)
        return Design(rule, (*parts, DesignPart(final)), "xor", first=len(parts) - 1)
    parts = _links(rule, k, changes, norm)
    return None if parts is None else Design(rule, parts, "last")


def _links(rule: WindowRule, k: Signs, changes: list[float], norm: Norm) -> tuple[DesignPart, ...] | None:
    """The templates of a chain for an odd number of changes, the innermost first."""
    middle = len(changes) // 2
    parts: list[DesignPart] = []
    before: Signs | None = None
    for reach in range(middle + 1):
        inside = changes[middle - reach : middle + reach + 1]
        parity = np.searchsorted(np.array(inside), k) % 2
        wanted = np.where(parity == 1, 1, -1).astype(np.int8)
        rows = rule.rows if before is None else np.column_stack([rule.rows, before])
        found = separate(rows, wanted, norm)
        if not isinstance(found, Separator):
            return None
        parts.append(DesignPart(found, "none" if before is None else "last"))
        before = wanted
    return tuple(parts)
