"""Savings: computations that can be omitted without a change of the output; which of them apply to a transient."""

import math
from collections.abc import Iterable
from typing import Literal

from cnnsim.network import CellModel, Tap, Template, reach
from cnnsim.planning.scheme import Scheme

Saving = Literal["closed form", "sparse taps", "shared sums", "blocking", "sleep"]
"""Each can be switched off."""

MOST_HALO = 25
"""Most rows and columns around a tile that are computed twice in one pass."""


def halo_of_a_step(taps: Iterable[Tap], scheme: Scheme) -> int:
    """Return the distance of the farthest cells that a step reads: the radius of the taps for each stage."""
    return reach((tap.k, tap.l) for tap in taps) * len(scheme.b)


def steps_a_pass(steps: int, halo: int) -> int:
    """Return how many of ``steps`` are taken in one pass, while the rows of a tile are in the cache.

    Each step of a tile needs ``halo`` more rows and columns around it; `MOST_HALO` is the limit.
    """
    most = max(1, MOST_HALO // max(halo, 1))
    return math.ceil(steps / max(1, math.ceil(steps / most)))


def stepped_savings(
    template: Template, scheme: Scheme, h: float, cell: CellModel, steps: int, *, settles: bool
) -> list[tuple[Saving, str]]:
    """Return the savings that apply to a stepped transient, each with its reason.

    ``steps`` is their number, or the number between two checks whether the network has settled.
    """
    taps, entries = len(template.feedback_taps), template.A.size
    found: list[tuple[Saving, str]] = [("sparse taps", f"{taps} of the {entries} entries of A are not zero")]
    if template.isotropic and template.A.shape[0] == 3 and template.A[0, 0]:
        found.append(("shared sums", "A is the same in all directions: neighbours are added before they are weighed"))
    depth, stages = steps_a_pass(steps, halo_of_a_step(template.feedback_taps, scheme)), len(scheme.b)
    together = f"{depth} steps" if stages == 1 else f"{depth} steps of {stages} stages" if depth > 1 else "all stages"
    found.append(("blocking", f"{together} a pass while the rows of a tile are in the cache"))
    if stages == 1 and settles and h <= 1 and cell == "chua-yang" and not template.uncoupled:
        found.append(("sleep", "tiles in which no output can change are left out"))
    return found
