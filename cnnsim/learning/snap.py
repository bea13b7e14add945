"""Snapping: trained weights on a coarse grid, with the same outputs and no smaller margin."""

from collections.abc import Callable, Sequence

import numpy as np

from cnnsim.learning.stage import Stage
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import Template
from cnnsim.prototyping.robust.margin import margin_of

GRIDS = (*((n, 1.0) for n in range(1, 9)), *((n, 0.5) for n in range(9, 17)), *((n, 0.25) for n in range(18, 33, 2)))
"""Tried grids, the coarsest first: the largest weight in steps, and the step, which keeps it within 8."""


def snapped(
    templates: Sequence[Template], stages: Sequence[Stage], right: Callable[[Sequence[Template]], bool]
) -> tuple[tuple[Template, ...], float]:
    """Return templates with the weights A - I, B and z in whole steps of a grid, and the step; 0 if that fails.

    The three are scaled together, which keeps the signs of the drives between black and white cells. A grid is taken if
    the templates are ``right``, and each tolerates relative errors of its entries no smaller than before
    (`Margin.tolerated`).
    """
    found, coarsest = list(templates), 1.0
    for number, (template, stage) in enumerate(zip(templates, stages, strict=True)):
        if not template.linear:
            return tuple(templates), 0.0
        tolerated = _tolerated(template, stage)
        for levels, step in GRIDS:
            trial = [*found[:number], _on_grid(template, levels, step), *found[number + 1 :]]
            if _tolerated(trial[number], stage) >= tolerated and right(trial):
                found, coarsest = trial, min(coarsest, step)
                break
        else:
            return tuple(templates), 0.0
    return tuple(found), coarsest


def _on_grid(template: Template, levels: int, step: float) -> Template:
    """Return a template whose largest weight is ``levels`` steps."""
    own = np.zeros_like(template.A)
    own[own.shape[0] // 2, own.shape[0] // 2] = 1.0
    parts = template.A - own, template.B, np.array(template.z)
    largest = max(float(np.abs(part).max()) for part in parts)
    a, b, z = (np.rint(part * (levels / largest)) * step + 0.0 for part in parts)
    return Template(a + own, b, float(z), template.name)


def _tolerated(template: Template, stage: Stage) -> float:
    entry = LibraryEntry("trial", "", "", template, stage.input, stage.initial_state, tags=("binary",))
    return margin_of(entry).tolerated or 0.0
