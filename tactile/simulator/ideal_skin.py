"""The skin of a scene without effects: the contacts of every finger, and the field that they make at the taxels."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.field import Contact, Field
from tactile.simulator.taxels import TaxelLayout

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps

CHUNK = 512
"""Frames computed in one call: those of 8 x 8 taxels fit into the second-level cache."""
LOADS = 1 << 22
"""Load components computed in one call: with very many loads a chunk has fewer frames."""


@dataclass(frozen=True, eq=False)
class IdealSkin:
    """The fields of a scene on incompressible half-spaces, as in the paper.

    ``pressing``: all loads and contacts; ``samples``: frames of each finger, at ``rate`` [Hz]; the rest as of `Scene`.
    """

    arrays: tuple[TaxelArray, ...]
    modulus: float
    pressing: tuple[Contact, ...]
    rate: float
    samples: int
    accuracy: float
    bumps: "Bumps | None"

    def medium(self, finger: int) -> Medium:
        """The cover of a finger; forces are sums of stress."""
        quantity = self.arrays[finger].quantity
        return Medium(self.modulus, quantity="stress" if quantity == "force" else quantity)

    def contacts(self, finger: int) -> tuple[Contact, ...]:
        """All that presses on a finger."""
        return tuple(one for one in self.pressing if one.finger == finger)

    def field(self, finger: int, times: Floats, first: int = 0) -> Field:
        """The field at the taxels at any times [s], the first of them that of frame ``first``."""
        array = self.arrays[finger]
        return Field(
            array, self.medium(finger), times, first, self.contacts(finger), TaxelLayout.of(array),
            accuracy=self.accuracy, bumps=self.bumps,
        )  # fmt: skip

    def fields(self, finger: int, times: Iterable[tuple[int, Floats]]) -> Iterator[Field]:
        """The fields of chunks (first frame, times)."""
        for first, piece in times:
            yield self.field(finger, piece, first)

    def chunks(self, finger: int) -> Iterator[tuple[int, Floats]]:
        """(first frame, times) of the chunks in which a finger's frames are computed."""
        count = max(1, min(CHUNK, LOADS // max(1, COLUMNS * self._loads(finger))))
        for start in range(0, self.samples, count):
            yield start, np.arange(start, min(start + count, self.samples)) / self.rate

    def _loads(self, finger: int) -> int:
        """The number of loads in a frame, without height maps, whose loads are summed in parts."""
        contacts = tuple(one for one in self.contacts(finger) if not isinstance(one, HeightMap))
        if all(type(one) is MovingLoad for one in contacts):
            return len(contacts)
        return replace(self.field(finger, np.zeros(1)), contacts=contacts).loads.count
