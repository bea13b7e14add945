"""Design: a sequence of templates, and the logic function that joins their outputs."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.network import Template
from cnnsim.prototyping.design.linear import Certificate, Norm, Separator
from cnnsim.prototyping.design.rule import Signs, WindowRule

StateSource = Literal["none", "state", "last"]
"""The initial state of a template: without weight, the user's plane, or the output of the previous template."""


@dataclass(frozen=True)
class DesignPart:
    """One template of a design: a threshold on the nine cells, and on one plane more as initial state.

    ``separator`` has nine weights, and a tenth if ``state`` is not "none". A negative tenth weight means that the
    plane is turned to its negative first, since a cell remembers its initial state only with a > 1.
    """

    separator: Separator
    state: StateSource = "none"

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


def part_of(separator: Separator) -> DesignPart:
    """Return a threshold as a part; a tenth weight, of the initial state, is kept if it is not zero."""
    if len(separator.weights) == 10 and separator.weights[9]:
        return DesignPart(separator, "state")
    return DesignPart(Separator(separator.weights[:9], separator.bias))


@dataclass(frozen=True, repr=False)
class Design:
    """Templates run one after the other and the logic function that joins their outputs.

    ``join`` is "or", "and" or "xor" of the outputs from number ``first`` on, or "last": the output of the last
    template, which starts from the ones before. ``certificate`` proves that no single template exists.
    """

    rule: WindowRule
    parts: tuple[DesignPart, ...]
    join: Literal["last", "or", "and", "xor"]
    certificate: Certificate | None = None
    first: int = 0

    def __repr__(self) -> str:
        return f"Design({self.rule.text!r}, {self._joined()}: {list(self.templates())})"

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading

        parts = "".join(template._repr_html_() for template in self.templates())
        return heading("Design", f"{self.rule.text}; {self._joined()}, margin {self.relative_margin():.4g}") + parts

    def templates(self) -> Iterator[Template]:
        """Yield the templates, numbered in the order in which they run."""
        for number, part in enumerate(self.parts, start=1):
            yield part.template(f"part {number}")

    def _joined(self) -> str:
        count = len(self.parts)
        return "one template" if count == 1 else f"{count} templates, joined by {self.join}"

    @property
    def one_template(self) -> bool:
        """True if one template is all, without a program around it."""
        return len(self.parts) == 1 and not self.parts[0].negated

    def outputs(self) -> list[Signs]:
        """Return each template's output for all rows of the rule."""
        found: list[Signs] = []
        for part in self.parts:
            rows = self.rule.rows
            if part.state == "last":
                rows = np.column_stack([rows[:, :9], found[-1]])
            elif part.state == "none":
                rows = rows[:, :9]
            found.append(part.separator.colours(rows))
        return found

    def answer(self) -> Signs:
        """Return the design's answer for all rows of the rule."""
        outputs = np.array(self.outputs()[self.first :])
        if self.join == "last":
            return outputs[-1]
        if self.join == "xor":
            return np.where((outputs > 0).sum(axis=0) % 2 == 1, 1, -1).astype(np.int8)
        return outputs.max(axis=0) if self.join == "or" else outputs.min(axis=0)

    def right(self) -> bool:
        """Return whether the answer is that of the rule on all windows that are black or white."""
        return bool((self.answer() * self.rule.table >= 0).all())

    def relative_margin(self, norm: Norm = "sum") -> float:
        """Return the smallest margin of the templates, relative to the norm of their weights."""
        return min(part.separator.relative_margin(norm) for part in self.parts)
