"""Separable rules: one template of maximal margin for a rule, or the certificate that there is none."""

import numpy as np

from cnnsim.prototyping.design.design import Design, DesignPart
from cnnsim.prototyping.design.linear import Certificate, Norm, Separator, separate
from cnnsim.prototyping.design.rule import Signs, WindowRule


def separable_design(rule: WindowRule, norm: Norm = "sum") -> Design | Certificate:
    """Return the one template for a rule, or the certificate that there is none."""
    found = separate_rule(rule, rule.table, norm)
    if isinstance(found, Certificate):
        return found
    result = Design(rule, (DesignPart(found, "state" if rule.with_state and found.weights[9] else "none"),), "last")
    if result.parts[0].state == "none":
        result = Design(rule, (DesignPart(Separator(found.weights[:9], found.bias)),), "last")
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
    same = [place for place in places if np.array_equal(table[_index(rule.rows[:, place])], table)]
    weights = tuple(sum((found.weights[place[i]] for place in same), 0 * found.bias) / len(same) for i in range(count))
    mean = Separator(weights, found.bias)
    return mean if mean.relative_margin(norm) >= found.relative_margin(norm) else found


def _index(rows: Signs) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    powers = 1 << np.arange(rows.shape[1])[::-1]
    found: np.ndarray[tuple[int], np.dtype[np.int64]] = (rows > 0).astype(np.int64) @ powers
    return found
