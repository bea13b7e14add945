"""Needle vibration: the needle's place and its height over the cover tremble."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.core.loads import F
from tactile.simulator.checks import within
from tactile.simulator.field import Field, field_at
from tactile.simulator.held_needle import force_factor


@dataclass(frozen=True)
class NeedleVibration:
    """Every frame all contacts of a finger are displaced together, x and y by ``lateral`` and z by ``vertical`` [m].

    Statistics: the displacements are independent from frame to frame (vibration is faster than the frames), normal,
    of mean 0 and of these standard deviations. The height changes the force of a held tip of ``tip_radius`` [m] by
    (1 + z / delta)^1.5: "a few microns of dislocation in the loading needle causes huge changes in the force".

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    lateral: float = 1e-6
    vertical: float = 0.5e-6
    tip_radius: float = 50e-6

    STAGE: ClassVar[str] = "field"
    RANDOM: ClassVar[bool] = True
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {
        "lateral_um": ("lateral", 1e-6),
        "vertical_um": ("vertical", 1e-6),
        "tip_radius_um": ("tip_radius", 1e-6),
    }
    NONE: ClassVar[Mapping[str, Any]] = {"lateral": 0.0, "vertical": 0.0}

    def __post_init__(self) -> None:
        within("lateral", self.lateral)
        within("vertical", self.vertical)
        within("tip_radius", self.tip_radius, 1e-12)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the contacts where the rig has them."""
        for field in stream:
            moves = random.standard_normal((len(field.times), 1, 3)) * (self.lateral, self.lateral, self.vertical)
            if not moves.any():
                yield field
                continue
            forces = field.loads.totals[..., F]
            shift = np.broadcast_to(moves[..., :2], (*forces.shape, 2))
            factor = force_factor(forces, np.broadcast_to(moves[..., 2], forces.shape), self.tip_radius, field.medium)
            loads = field.loads.moved(shift, factor)
            at, depth = field.array.positions(), field.array.depth
            term = field_at(at, depth, loads, field.medium) - field_at(at, depth, field.loads, field.medium)
            yield replace(field, loads=loads, values=field.values + term)
