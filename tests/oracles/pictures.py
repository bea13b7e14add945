"""Binary pictures of the oracles, and the planes of a worked example."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Picture = npt.NDArray[np.bool_]
Plane = npt.NDArray[np.float64]

CROSS: Picture = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], dtype=bool)
SQUARE: Picture = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True)
class Case:
    """The planes of a worked example: the input, the initial state, the mask and the bias map."""

    u: Plane | None = None
    x0: Plane | None = None
    mask: Picture | None = None
    bias: Plane | None = None

    @property
    def picture(self) -> Plane:
        """The first picture of the example: its input, or its state where it has no input."""
        chosen = self.u if self.u is not None else self.x0
        assert chosen is not None
        return chosen

    @property
    def start(self) -> Plane:
        """The initial state, or the input if the template starts from its input."""
        chosen = self.x0 if self.x0 is not None else self.u
        assert chosen is not None
        return chosen


def black(plane: Plane) -> Picture:
    """Which cells of a plane are black."""
    return np.asarray(plane > 0, dtype=bool)


def plane(picture: Picture) -> Plane:
    """Black to +1, white to -1."""
    return np.where(picture, 1.0, -1.0)
