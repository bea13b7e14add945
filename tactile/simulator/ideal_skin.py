"""The skin of a scene without effects: what presses on every finger, and the field that it makes at the taxels."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS
from tactile.elastic.medium import Felt, Medium
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.field import Contact, Field
from tactile.simulator.taxels import Taxels

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps

CHUNK = 512
"""Frames computed at once: those of 8 x 8 taxels stay in the second-level cache from effect to effect."""
LOADS_AT_ONCE = 1 << 22
"""Load components held at once: scenes with very many loads are computed in smaller pieces."""
FEW = 4
"""Point loads that are not counted: pieces are as long as they may be."""
KEPT = 1 << 18
"""Most readings of a field that is kept for the next run: 2 MiB."""


@dataclass(frozen=True, eq=False)
class IdealSkin:
    """The fields of a scene as the paper has them, on incompressible, endless covers; what is found out is kept.

    ``pressing``: all loads and contacts; ``samples``: frames of each finger, at ``rate`` [Hz]; the rest as `Scene` has
    it.
    """

    arrays: tuple[TaxelArray, ...]
    modulus: float
    pressing: tuple[Contact, ...]
    rate: float
    samples: int
    accuracy: float
    bumps: "Bumps | None"

    def medium(self, finger: int) -> Medium:
        """The cover of a finger."""
        return self._fingers[finger][2]

    def taxels(self, finger: int) -> Taxels:
        """Where the taxels of a finger lie."""
        return self._fingers[finger][1]

    def loads(self, finger: int, times: Floats) -> Loads:
        """All loads on a finger at the times [s]."""
        return self.field(finger, times).loads

    def field(self, finger: int, times: Floats, first: int = 0) -> Field:
        """The field at the taxels at any times [s], the first of them that of frame ``first``."""
        mine, taxels, medium = self._fingers[finger]
        return Field(
            self.arrays[finger], medium, times, first, mine, taxels,
            accuracy=self.accuracy, bumps=self.bumps,
        )  # fmt: skip

    def fields(self, finger: int, times: Iterable[tuple[int, Floats]]) -> Iterator[Field]:
        """The field for pieces (first frame, times), computed or kept."""
        kept = self._kept.get(finger)
        for first, piece in times:
            if kept is not None and np.array_equal(kept.times[first : first + len(piece)], piece):
                yield kept.again(self.accuracy, first, piece)
            else:
                yield self.field(finger, piece, first)

    def keep(self, finger: int, whole: Field) -> None:
        """Keep the computed field of all frames of a finger for the next run."""
        if whole.values.size <= KEPT:
            self._kept[finger] = whole

    def to_accuracy(self, accuracy: float) -> "IdealSkin":
        """The same skin with fields of another accuracy; what was kept stays."""
        made: IdealSkin = object.__new__(type(self))
        made.__dict__.update(self.__dict__, accuracy=accuracy)
        return made

    def pieces(self, finger: int) -> Iterator[tuple[int, Floats]]:
        """(first frame, times) of the pieces in which a finger's frames are computed."""
        count = max(1, min(CHUNK, LOADS_AT_ONCE // max(1, COLUMNS * self._load_counts[finger])))
        for start in range(0, self.samples, count):
            yield start, np.arange(start, min(start + count, self.samples)) / self.rate

    @cached_property
    def _fingers(self) -> list[tuple[tuple[Contact, ...], Taxels, Medium]]:
        """What presses on every finger, its taxels and its cover, which are the same in all pieces."""
        return [
            (
                tuple(one for one in self.pressing if one.finger == finger),
                Taxels.of(array),
                Medium(self.modulus, quantity=cast(Felt, array.quantity)),
            )
            for finger, array in enumerate(self.arrays)
        ]

    @cached_property
    def _load_counts(self) -> list[int]:
        """Loads on every finger in a frame, without those of height maps, which are summed in pieces of their own."""
        counts = []
        for finger, (mine, _, _) in enumerate(self._fingers):
            counted = tuple(one for one in mine if not isinstance(one, HeightMap))
            few = len(counted) < FEW and all(type(one) is MovingLoad for one in counted)
            counts.append(FEW if few else replace(self.field(finger, np.zeros(1)), contacts=counted).loads.count)
        return counts

    @cached_property
    def _kept(self) -> dict[int, Field]:
        return {}
