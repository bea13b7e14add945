"""Separable rules: one template of maximal margin for a rule, or the certificate that there is none."""

import numpy as np

from cnnsim.prototyping.design.design import Design, part_of
from cnnsim.prototyping.design.linear import Certificate, Norm, Separator, separate
from cnnsim.prototyping.design.rule import Signs, WindowRule, window_numbers


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
