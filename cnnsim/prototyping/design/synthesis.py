"""From a rule to templates: a single one where a threshold exists, else a few, joined by the logic unit."""

from cnnsim.prototyping.design.decompose import decompose
from cnnsim.prototyping.design.design import Design
from cnnsim.prototyping.design.linear import Norm
from cnnsim.prototyping.design.rule import Rule
from cnnsim.prototyping.design.separable import single


def design(rule: Rule, norm: Norm = "sum") -> Design:
    """Return templates for a rule: one of maximal margin if there is one, else as few as the search finds.

    The decomposition is right on every window by construction, and checked; it need not be the shortest there is.
    """
    found = single(rule, norm)
    if isinstance(found, Design):
        return found
    result = decompose(rule, found, norm)
    assert result.right()
    return result
