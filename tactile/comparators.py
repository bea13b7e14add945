"""Comparators: the cells that watch traction planes, with the memory that hysteresis needs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.machine import UniversalMachine
from cnnsim.program_file import load_program
from tactile.encoding import Code, Threshold, decode


class Comparators:
    """The analogic program ``event-code`` with its thresholds, running on one grid of planes.

    ``code`` is what the cells say now, ``before`` what they said one frame ago.
    """

    def __init__(self, machine: UniversalMachine, shape: tuple[int, int], shear: Threshold, contact: Threshold) -> None:
        cells = {"plus": shear.comparator(1), "minus": shear.comparator(-1), "press": contact.comparator(1)}
        self._machine, self._program = machine, load_program("event-code", templates=cells)
        nothing = np.zeros(shape, dtype=np.int8)
        self.code = self.before = Code(nothing, nothing, nothing.astype(bool))

    def update(self, planes: dict[str, NDArray[Any]]) -> bool:
        """Take the planes of `encode` and return whether the code has changed."""
        out = self._machine.run(self._program, **planes)
        self.before, self.code = self.code, decode(out)
        return bool(out["moved"])
