"""Savings: the ways of computing less for the same output, and which of them apply to a stepped transient."""

import math
from typing import Literal

from cnnsim.network import CellModel, Template, reach
from cnnsim.planning.scheme import Scheme

Saving = Literal["closed form", "sparse taps", "shared sums", "blocking", "sleep"]
"""A plan can be made without any of them, for comparison."""

MOST_HALO = 25
"""Cells around a tile that are computed again for the steps of one pass."""


def steps_a_pass(steps: int, radius: int) -> int:
    """Return how many of so many steps are taken while the rows of a tile are in the cache.

    Each step of a tile needs ``radius`` rows and columns more around it; `MOST_HALO` of them cost less than they save.
    """
    most = max(1, MOST_HALO // max(radius, 1))
    return math.ceil(steps / max(1, math.ceil(steps / most)))


def stepped_savings(
    template: Template, scheme: Scheme, h: float, cell: CellModel, steps: int, *, settles: bool
) -> list[tuple[Saving, str]]:
    """Return the savings that apply to a stepped transient, each with its reason.

    ``steps``: how many are taken, or lie between two checks whether the network has settled.
    """
    taps, entries = len(template.feedback_taps), template.A.size
    found: list[tuple[Saving, str]] = [("sparse taps", f"{taps} of the {entries} entries of A are not zero")]
    if template.isotropic and template.A.shape[0] == 3 and template.A[0, 0]:
        found.append(("shared sums", "A is the same in all directions: neighbours are added before they are weighed"))
    if len(scheme.b) == 1:
        depth = steps_a_pass(steps, reach((k, l) for k, l, _ in template.feedback_taps))
        found.append(("blocking", f"one-stage scheme: {depth} steps a pass while the rows of a tile are in the cache"))
        if settles and h <= 1 and cell == "chua-yang" and not template.uncoupled:
            found.append(("sleep", "tiles in which no output can change are left out"))
    return found
