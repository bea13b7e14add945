"""Comparators: CNN cells that compare traction planes with thresholds, with hysteresis."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cnnsim.library.folders import folder
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.support import Flags, Floats
from tactile.events.code import Code, decode
from tactile.thresholds.threshold import Threshold

BINARY = Threshold(1 / 6, 1 / 12)
"""The binary scale: off below 1/6, on above 1/4."""
AS_THEY_ARE, ONCE = np.arange(3), np.ones(3)
SLACK = 1e-6
"""Distance in CNN value from every threshold at which a comparator is skipped; far above rounding."""


class Comparators:
    """The analogic program ``event-code`` with given thresholds on one grid of planes.

    The program is skipped while no cell can switch. With A = 2 a white cell turns black only above its upper threshold,
    and a black cell turns white only below its lower threshold (`Threshold.comparator`); between them the program would
    return the state it keeps. ``code`` is the current code, ``before`` that of the previous frame.
    """

    def __init__(self, machine: UniversalMachine, shape: tuple[int, int], shear: Threshold, contact: Threshold) -> None:
        from tactile.events.signals.step_numba import quiet  # numba is slow to import

        self._quiet = quiet
        cells = {"plus": shear.comparator(1), "minus": shear.comparator(-1), "press": contact.comparator(1)}
        self._machine, self._program = machine, load_program(shipped("event-code"), templates=cells)
        machine.prepare(self._program, shape)
        (off, on), (gone, touched) = _levels(shear), _levels(contact)
        along = np.array([-np.inf, -on, off]) + SLACK, np.array([-off, on, np.inf]) - SLACK  # of a code -1, 0, +1
        pressed = np.array([-np.inf, gone]) + SLACK, np.array([touched, np.inf]) - SLACK
        self._bounds = along, along, pressed
        nothing = np.zeros(shape, dtype=np.int8)
        self.code = self.before = Code(nothing, nothing, nothing.astype(bool))
        self._set_quiet_range()

    def update(self, planes: Floats) -> bool:
        """Process the planes shear_x, shear_y, pressing (3, rows, cols) of `encode`; return whether the code changed.

        Further planes are ignored.
        """
        if self._quiet(planes, AS_THEY_ARE, ONCE, self._low, self._high):
            self.before = self.code
            return False
        out = self._machine.run(self._program, shear_x=planes[0], shear_y=planes[1], pressing=planes[2])
        self.before, self.code = self.code, decode(out)
        if out["moved"]:
            self._set_quiet_range()
        return bool(out["moved"])

    def _set_quiet_range(self) -> None:
        """Store the input range (3, rows, cols) in which no cell switches."""
        code = self.code
        cells = code.x + 1, code.y + 1, code.contact.view(np.int8)
        self._low = np.array([low[kind] for (low, _), kind in zip(self._bounds, cells, strict=True)])
        self._high = np.array([high[kind] for (_, high), kind in zip(self._bounds, cells, strict=True)])


class Switches:
    """The analogic program ``comparators`` on planes in the binary scale; skipped while no cell can switch.

    Arguments: ``shape`` (rows, cols); ``sources``: index of the plane of each of the n signals; ``factors``: its
    factor. ``on`` (n, rows, cols) holds the state of each signal.
    """

    def __init__(
        self, machine: UniversalMachine, shape: tuple[int, int], sources: Sequence[int], factors: Sequence[float]
    ) -> None:
        from tactile.events.signals.step_numba import quiet  # numba is slow to import

        self._quiet = quiet
        self._machine, self._program = machine, load_program(shipped("comparators"))
        machine.prepare(self._program, (len(sources), *shape))
        self._off, self._on = _levels(BINARY)
        self._sources, self._factors = np.array(sources), np.array(factors, dtype=np.float64)
        self.on: Flags = np.zeros((len(sources), *shape), dtype=bool)
        self._set_quiet_range()

    def update(self, planes: Floats) -> bool:
        """Process planes (planes, rows, cols) and return whether any cell has switched."""
        if self._quiet(planes, self._sources, self._factors, self._low, self._high):
            return False
        on = self._machine.run(self._program, signal=planes[self._sources] * self._factors[:, None, None])["on"]
        switched = not np.array_equal(on, self.on)
        self.on = on
        self._set_quiet_range()
        return switched

    def _set_quiet_range(self) -> None:
        self._low = np.where(self.on, self._off + SLACK, -np.inf)
        self._high = np.where(self.on, np.inf, self._on - SLACK)


def shipped(name: str) -> Path:
    """Return the file of a program of the shipped library, which users' files of that name never replace."""
    return folder() / "programs" / f"{name}.toml"


def _levels(threshold: Threshold) -> tuple[float, float]:
    """Return the CNN values below which a cell turns white and above which it turns black."""
    return (
        threshold.dead_band / threshold.full_scale,
        (threshold.dead_band + threshold.hysteresis) / threshold.full_scale,
    )
