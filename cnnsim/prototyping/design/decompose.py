"""Decompose a rule into templates: one if a threshold exists, else the fewest of five constructions.

* count chain: the rule depends only on one weighted count k, and changes its colour t times as k grows. Each further
  template, whose initial state is the negative of the previous output, adds two changes: (t + 1) / 2 templates for
  odd t.
* xor: one template that is right on most windows, and a second that is black exactly on the others.
* turned: the rule is one of the window, xor the initial state; that state is a template of its own.
* or, and: thresholds that are black (white) only on some of the black (white) windows, until all are covered
  (greedy; minimal covers are NP-hard).
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Literal

import numpy as np

from cnnsim.prototyping.design.count_chain import count_chain
from cnnsim.prototyping.design.design import Design, DesignPart, part_of
from cnnsim.prototyping.design.linear import Certificate, Norm, Separator, separate, soft_margin_colours
from cnnsim.prototyping.design.rule import Signs, WindowRule, window_numbers
from cnnsim.support import Flags, InputError

_TRIES = 12
"""Number of random weightings of the windows tried for each template of a cover, and for a pair joined by xor."""


MOST = 32
"""Templates of a design, unless more are allowed: each takes the search about a second."""


def design_rule(rule: WindowRule, norm: Norm = "sum", most: int = MOST) -> Design:
    """Return templates for a rule: one of maximal margin if there is one, else as few as the search finds.

    The decomposition is right on every window by construction, and checked; it need not be the shortest there is.

    Raises:
        InputError: more than ``most`` templates are needed.
    """
    found = separable_design(rule, norm)
    return found if isinstance(found, Design) else decompose(rule, found, norm, most)


def decompose(rule: WindowRule, certificate: Certificate, norm: Norm = "sum", allowed: int = MOST) -> Design:
    """Return a design of several templates for a rule; ``certificate`` proves that no single template computes it."""
    found: list[Design] = []
    searches: tuple[Callable[[int], Design | None], ...] = (
        lambda _: count_chain(rule, norm),
        lambda _: _xor(rule, norm),
        lambda most: _turned(rule, norm, most),
        lambda most: _cover(rule, "or", norm, most),
        lambda most: _cover(rule, "and", norm, most),
    )
    for search in searches:
        most = min((len(design.parts) - 1 for design in found), default=allowed)
        design = search(most) if most > 1 else None
        if design is not None and design.right():
            found.append(design)
    if not found:
        raise InputError(
            f"rule {rule.text!r}: no design of at most {allowed} templates found; a simpler rule, or more templates "
            "(--most), wanted"
        )
    shortest = min(found, key=lambda design: (len(design.parts), -design.relative_margin(norm)))
    result = Design(rule, shortest.parts, shortest.join, certificate, shortest.first)
    assert result.right()
    return result


def _xor(rule: WindowRule, norm: Norm) -> Design | None:
    rng, best = np.random.default_rng(0), None
    for trial in range(_TRIES):
        weights = np.ones(rule.table.size) if trial == 0 else rng.exponential(size=rule.table.size) ** 2
        first = soft_margin_colours(rule.rows, rule.table, weights)
        if first is None:
            continue
        difference = np.where(rule.table == 0, 0, -first * rule.table).astype(np.int8)
        if not ((difference > 0).any() and (difference < 0).any()):
            continue
        one, two = separate_rule(rule, first, norm), separate_rule(rule, difference, norm)
        if isinstance(one, Separator) and isinstance(two, Separator):
            design = Design(rule, (part_of(one), part_of(two)), "xor")
            if best is None or design.relative_margin(norm) > best.relative_margin(norm):
                best = design
    return best


def _turned(rule: WindowRule, norm: Norm, most: int) -> Design | None:
    """Return a design of the rule of the window that is xored with the initial state, and of that state."""
    if not rule.with_state:
        return None
    white, black = rule.table[::2], rule.table[1::2]  # the answers where the state is white, black
    if (white * black > 0).any():
        return None
    inner = WindowRule(np.where(white != 0, white, -black), rule.text)
    one = separable_design(inner, norm)
    found = one if isinstance(one, Design) else count_chain(inner, norm) or _xor(inner, norm)
    if found is None or len(found.parts) >= most:
        return None
    state = DesignPart(Separator((*[Fraction(0)] * 9, Fraction(1)), Fraction(0)), "state")
    first = found.first if found.join == "xor" else len(found.parts) - 1
    return Design(rule, (*found.parts, state), "xor", first=first)


def _cover(rule: WindowRule, join: Literal["or", "and"], norm: Norm, most: int) -> Design | None:
    """Cover the black windows by thresholds that are white on all white windows (for "and" with the colours swapped).

    None if more than ``most`` are needed, or would be if none covered twice as much as the best so far.
    """
    colour = 1 if join == "or" else -1
    table, rng = rule.table * colour, np.random.default_rng(0)
    left = table == 1
    parts: list[DesignPart] = []
    largest = int(left.sum())
    while left.any():
        if left.sum() > 2 * largest * (most - len(parts)):
            return None
        covered = _largest_part(rule, table, left, rng)
        wanted = np.where(covered, 1, np.where(table == -1, -1, 0)).astype(np.int8)
        found = separate_rule(rule, (wanted * colour).astype(np.int8), norm)
        assert isinstance(found, Separator)
        before, left = left, left & (found.colours(rule.rows) * colour < 0)
        gained = int(before.sum() - left.sum())
        largest = max(largest, gained) if parts else gained
        parts.append(part_of(found))
    return Design(rule, tuple(parts), join)


def _largest_part(rule: WindowRule, table: Signs, left: Flags, rng: np.random.Generator) -> Flags:
    """Return many of the windows in ``left`` that one threshold can separate from all white ones."""
    goal = np.where(left, 1, np.where(table == -1, -1, 0)).astype(np.int8)
    alone = np.zeros_like(left)
    alone[np.flatnonzero(left)[0]] = True  # a single window can always be separated from all others
    best = alone
    for trial in range(_TRIES):
        weights = np.ones(table.size) if trial == 0 else rng.exponential(size=table.size) ** 2
        first = soft_margin_colours(rule.rows, goal, weights, hard=-1)
        if first is None:
            continue
        covered = left & (first > 0)
        if covered.sum() > best.sum():
            best = covered
    return best


def separable_design(rule: WindowRule, norm: Norm = "sum") -> Design | Certificate:
    """Return the one template for a rule, or the certificate that there is none."""
    found = separate_rule(rule, rule.table, norm)
    if isinstance(found, Certificate):
        return found
    result = Design(rule, (part_of(found),), "last")
    assert result.right()
    return result


def separate_rule(rule: WindowRule, table: Signs, norm: Norm = "sum") -> Separator | Certificate:
    """Separate a table over the rule's rows; the weights share the table's symmetries (turns and mirrors).

    The mean of all turned and mirrored solutions is a solution of the same norm or less, as both are convex.
    """
    found = separate(rule.rows, table, norm)
    if isinstance(found, Certificate):
        return found
    count = rule.rows.shape[1]
    grid = np.arange(9).reshape(3, 3)
    turned = [np.rot90(flip, k).ravel() for flip in (grid, grid.T) for k in range(4)]
    places = [np.concatenate([turn, np.arange(9, count)]) for turn in turned]
    same = [place for place in places if np.array_equal(table[window_numbers(rule.rows[:, place])], table)]
    weights = tuple(sum((found.weights[place[i]] for place in same), 0 * found.bias) / len(same) for i in range(count))
    mean = Separator(weights, found.bias)
    return mean if mean.relative_margin(norm) >= found.relative_margin(norm) else found
