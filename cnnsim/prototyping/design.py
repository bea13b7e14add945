"""From a rule to templates: a single one where a threshold exists, else a few, joined by the logic unit."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.prototyping.linear import Bits, Certificate, Norm, Separator, separate
from cnnsim.prototyping.rule import Rule
from cnnsim.template import Template

Source = Literal["none", "state", "last"]
"""What the initial state of a template is: of no weight, the user's own plane, or the output of the template before."""


@dataclass(frozen=True)
class Part:
    """One template of a design: a threshold on the nine cells, and on one plane more as initial state.

    ``separator`` has nine weights, and a tenth if ``state`` is not "none". A negative tenth weight means that the
    plane is turned to its negative first, since a cell remembers its initial state only with a > 1.
    """

    separator: Separator
    state: Source = "none"

    @property
    def negated(self) -> bool:
        """Whether the initial state is the negative of its plane."""
        return self.state != "none" and self.separator.weights[9] < 0

    def template(self, name: str) -> Template:
        """Return the template: B and z from the threshold, a = 1, or 1 + |weight| of the initial state."""
        b = np.array([float(w) for w in self.separator.weights[:9]]).reshape(3, 3)
        a = 1.0 + (abs(float(self.separator.weights[9])) if self.state != "none" else 0.0)
        feedback = np.zeros((3, 3))
        feedback[1, 1] = a
        return Template(feedback, b, float(self.separator.bias), name)


@dataclass(frozen=True)
class Design:
    """Templates run one after the other and the logic function that joins their outputs.

    ``join`` is "or", "and" or "xor" of the outputs from number ``first`` on, or "last": the output of the last
    template, into which those before it have gone. ``certificate`` tells why a single template cannot do it.
    """

    rule: Rule
    parts: tuple[Part, ...]
    join: Literal["last", "or", "and", "xor"]
    certificate: Certificate | None = None
    first: int = 0

    @property
    def single(self) -> bool:
        """Whether one template is all."""
        return len(self.parts) == 1 and not self.parts[0].negated

    def outputs(self) -> list[Bits]:
        """Return each template's output for all rows of the rule."""
        found: list[Bits] = []
        for part in self.parts:
            rows = self.rule.rows
            if part.state == "last":
                rows = np.column_stack([rows[:, :9], found[-1]])
            elif part.state == "none":
                rows = rows[:, :9]
            found.append(part.separator.colours(rows))
        return found

    def answer(self) -> Bits:
        """Return the design's answer for all rows of the rule."""
        outputs = np.array(self.outputs()[self.first :])
        if self.join == "last":
            return outputs[-1]
        if self.join == "xor":
            return np.where((outputs > 0).sum(axis=0) % 2 == 1, 1, -1).astype(np.int8)
        return outputs.max(axis=0) if self.join == "or" else outputs.min(axis=0)

    def right(self) -> bool:
        """Return whether the answer is that of the rule wherever the rule says one."""
        return bool((self.answer() * self.rule.table >= 0).all())

    def relative_margin(self, norm: Norm = "sum") -> float:
        """Return the smallest of its templates' margins, each compared with the norm of its weights."""
        return min(part.separator.relative_margin(norm) for part in self.parts)


def design(rule: Rule, norm: Norm = "sum") -> Design:
    """Return templates for a rule: one of maximal margin if there is one, else as few as the search finds.

    The decomposition is right on every window by construction, and checked; it need not be the shortest there is.
    """
    from cnnsim.prototyping.decompose import decompose

    found = single(rule, norm)
    if isinstance(found, Design):
        return found
    result = decompose(rule, found, norm)
    assert result.right()
    return result


def single(rule: Rule, norm: Norm = "sum") -> Design | Certificate:
    """Return the one template for a rule, or the certificate that there is none."""
    found = separate_rule(rule, rule.table, norm)
    if isinstance(found, Certificate):
        return found
    result = Design(rule, (Part(found, "state" if rule.with_state and found.weights[9] else "none"),), "last")
    if result.parts[0].state == "none":
        result = Design(rule, (Part(Separator(found.weights[:9], found.bias)),), "last")
    assert result.right()
    return result


def separate_rule(rule: Rule, table: Bits, norm: Norm = "sum") -> Separator | Certificate:
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


def _index(rows: Bits) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    powers = 1 << np.arange(rows.shape[1])[::-1]
    found: np.ndarray[tuple[int], np.dtype[np.int64]] = (rows > 0).astype(np.int64) @ powers
    return found
