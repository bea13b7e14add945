"""The skin of a scene without effects: what presses on every finger, and the field that it makes at the taxels."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS
from tactile.elastic.medium import Felt, Medium
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.field import Contact, Field
from tactile.simulator.summation import DIRECT, FEW, Summation, choose_method
from tactile.simulator.taxels import Taxels

if TYPE_CHECKING:
    from tactile.elastic.sums.device_sum import DeviceSum
    from tactile.simulator.bump_cover import Bumps

CHUNK = 512
"""Frames computed at once: those of 8 x 8 taxels stay in the second-level cache from effect to effect."""
LOADS_AT_ONCE = 1 << 22
"""Load components held at once: scenes with very many loads are computed in smaller pieces."""
CHUNK_ON_DEVICE = 16_384
"""Frames sent to an OpenCL device at once."""
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
    backend: Literal["cpu", "opencl"]
    dtype: Literal["float32", "float64"]
    bumps: "Bumps | None"

    def medium(self, finger: int) -> Medium:
        """The cover of a finger."""
        return self._fingers[finger][2]

    def taxels(self, finger: int) -> Taxels:
        """Where the taxels of a finger lie."""
        return self._fingers[finger][1]

    def loads(self, finger: int, times: Floats) -> Loads:
        """All loads on a finger at the times [s]."""
        return self.field(finger, times, method=DIRECT).loads

    def method(self, finger: int) -> Summation:
        """The method of summation that was chosen for a finger."""
        return self._methods[finger]

    def field(self, finger: int, times: Floats, first: int = 0, method: Summation | None = None) -> Field:
        """The field at the taxels at any times [s], the first of them that of frame ``first``."""
        mine, taxels, medium = self._fingers[finger]
        return Field(
            self.arrays[finger], medium, times, first, mine, taxels,
            method=method or self.method(finger), accuracy=self.accuracy, bumps=self.bumps, device=self._device,
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
        most = CHUNK if self.backend == "cpu" else CHUNK_ON_DEVICE
        count = max(1, min(most, LOADS_AT_ONCE // max(1, COLUMNS * self._load_counts[finger])))
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
    def _methods(self) -> tuple[Summation, ...]:
        if self.bumps is not None:
            return (Summation("matrix", f"{self.bumps}"),) * len(self.arrays)
        return tuple(
            DIRECT if sample is None else choose_method(array, sample.points, self.samples)
            for array, sample in zip(self.arrays, self._sampled, strict=True)
        )

    @cached_property
    def _load_counts(self) -> list[int]:
        return [FEW if one is None else one.count for one in self._sampled]

    @cached_property
    def _sampled(self) -> list[Loads | None]:
        """What presses at points of every finger at a few moments, None of fewer than ``FEW`` loads: those are summed.

        Moments show whether loads move; a load that moves only between them is caught on the way. Height maps, which
        press on cells, take long to be pressed and are felt by tables, are left out.
        """
        found: list[Loads | None] = []
        for finger, (mine, _, _) in enumerate(self._fingers):
            asked = tuple(one for one in mine if not isinstance(one, HeightMap))
            few = len(asked) < FEW and all(type(one) is MovingLoad for one in asked)
            moments = np.zeros(0) if few else np.linspace(0, (self.samples - 1) / self.rate, min(self.samples, 5))
            sampled = replace(self.field(finger, moments, method=DIRECT), contacts=asked)
            found.append(None if few else sampled.loads)
        return found

    @cached_property
    def _device(self) -> "DeviceSum | None":
        if self.backend == "cpu":
            return None
        from tactile.elastic.sums.device_sum import device_sum  # only where called for

        return device_sum(self.dtype)

    @cached_property
    def _kept(self) -> dict[int, Field]:
        return {}
