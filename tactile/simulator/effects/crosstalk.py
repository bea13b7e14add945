"""Crosstalk: a taxel's channels mix with each other and with those of its neighbours."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within


@dataclass(frozen=True)
class Crosstalk:
    """Components gain ``cross_axis`` times the taxel's two others, then ``neighbour`` times the four neighbours'.

    Linear and without memory: y_c = x_c + cross_axis (x_a + x_b), then y += neighbour * sum of y over the neighbours
    to the north, south, west and east; outside the array there is nothing.

    Source: cross-axis matrix and mechanical coupling as in Vasarhelyi, Fodor, Roska, sects 2 and 5.
    """

    cross_axis: float = 0.01
    neighbour: float = 0.005

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = False
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {
        "cross_axis": ("cross_axis", 1.0),
        "neighbour": ("neighbour", 1.0),
    }
    NONE: ClassVar[Mapping[str, Any]] = {"cross_axis": 0.0, "neighbour": 0.0}

    def __post_init__(self) -> None:
        within("cross_axis", self.cross_axis, -1.0, 1.0)
        within("neighbour", self.neighbour, -1.0, 1.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Mixed frames."""
        for batch in stream:
            values = batch.values
            if self.cross_axis != 0:
                values = values + self.cross_axis * (values.sum(axis=-1, keepdims=True) - values)
            if self.neighbour != 0:
                around = np.zeros_like(values)
                around[:, 1:] += values[:, :-1]
                around[:, :-1] += values[:, 1:]
                around[:, :, 1:] += values[:, :, :-1]
                around[:, :, :-1] += values[:, :, 1:]
                values = values + self.neighbour * around
            yield replace(batch, values=values)
