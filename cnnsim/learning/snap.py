"""Snapping: trained weights on a coarse grid, with the same outputs and no smaller margin."""

from collections.abc import Callable, Sequence

import numpy as np

from cnnsim.learning.stage import Stage
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import Template
from cnnsim.prototyping.robust.margin import margin_of

LEVELS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 32)
"""Tried sizes of the largest weight in steps of the grid, the coarsest first."""


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
        for levels in LEVELS:
            trial = [*found[:number], _on_grid(template, levels), *found[number + 1 :]]
            if _tolerated(trial[number], stage) >= tolerated and right(trial):
                found, coarsest = trial, min(coarsest, 1.0 if levels <= 8 else 8 / levels)
                break
        else:
            return tuple(templates), 0.0
    return tuple(found), coarsest


def _on_grid(template: Template, levels: int) -> Template:
    """Return a template whose largest weight is ``levels`` steps, 8 at most."""
    own = np.zeros_like(template.A)
    own[own.shape[0] // 2, own.shape[0] // 2] = 1.0
    parts = template.A - own, template.B, np.array(template.z)
    largest = max(float(np.abs(part).max()) for part in parts)
    step = 1.0 if levels <= 8 else 8 / levels
    a, b, z = (np.rint(part * (levels / largest)) * step + 0.0 for part in parts)
    return Template(a + own, b, float(z), template.name)


def _tolerated(template: Template, stage: Stage) -> float:
    entry = LibraryEntry("trial", "", "", template, stage.input, stage.initial_state, tags=("binary",))
    return margin_of(entry).tolerated or 0.0
