"""Splits of windows into training and test sets: by slide, by block of slides, by place on the slide."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cnnsim.support import Integers
from tactile.materials.fit import learner
from tactile.materials.windows import WindowTable

FOLDS = 5
"""Number of folds of the slides."""


class Split(NamedTuple):
    """Indices of the training windows and of the test windows."""

    train: Integers
    test: Integers


def by_slide(table: WindowTable, window: int) -> Iterator[Split]:
    """Yield five splits of the slides, each with all materials; all windows of a slide are on one side."""
    folds = min(FOLDS, *(len(set(table.slide[table.material == one])) for one in set(table.material)))
    way = learner("model_selection").StratifiedGroupKFold(folds, shuffle=True, random_state=0)
    for train, test in way.split(table.values, table.material, table.slide):
        yield Split(train, _apart(table, test, window))


def by_block(table: WindowTable, window: int) -> Iterator[Split]:
    """Yield each block of slides as the test set; nothing for a single block."""
    for block in sorted(set(table.block)) if len(set(table.block)) > 1 else ():
        there = table.block == block
        known = np.isin(table.material, table.material[~there])
        test = np.flatnonzero(there & known)
        if test.size:
            yield Split(np.flatnonzero(~there), _apart(table, test, window))


def by_place(table: WindowTable, window: int) -> Iterator[Split]:
    """Yield each half of every slide as the test set: the same slides at another place of the material."""
    middle = np.array([one.t.size / 2 for one in table.slides])[table.slide]
    first, second = table.start + window <= middle, table.start >= middle
    for train, test in ((first, second), (second, first)):
        if train.any() and test.any():
            yield Split(np.flatnonzero(train), _apart(table, np.flatnonzero(test), window))


def _apart(table: WindowTable, test: Integers, window: int) -> Integers:
    """Return the test windows that do not overlap, from the first of each slide on."""
    slide, start = table.slide[test], table.start[test]
    first = {one: start[slide == one].min() for one in set(slide)}
    from_first = start - np.array([first[one] for one in slide])
    return test[from_first % window == 0]
