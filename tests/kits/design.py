"""Rules of library templates, written from the descriptions of their tasks."""

import numpy as np

from cnnsim.prototyping.design.rule import WindowRule, windows
from tests.oracles.windows import RULES, Window


def rule_of(name: str) -> WindowRule:
    """The rule of a library template, from its task in words and not from its numbers."""
    rows = (windows(9) > 0).reshape(512, 3, 3)
    cells = Window(*(rows[:, i, j] for i in range(3) for j in range(3)))
    return WindowRule(np.where(np.asarray(RULES[name](cells), dtype=bool), 1, -1), name)
