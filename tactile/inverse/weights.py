"""Signals of an array: their units and weights, the signals of one frame, and the program of the per-cell inverse."""

from typing import NamedTuple

import numpy as np

from cnnsim.library.folders import folder
from cnnsim.program.file import load_program
from cnnsim.program.program import Program
from cnnsim.support import Flags, Floats, InputError, Integers
from tactile.core.frame import TaxelArray

SPARSE = 2.0
"""Pitch [depths] above which weak taxels measure nothing of a load."""


class Weights(NamedTuple):
    """Weights of the signals of n taxels by their noise.

    ``noise``: median standard deviation of the signals, None if unknown; ``scale`` (n, 3): ``noise`` over the standard
    deviation of each signal; ``trust`` (n,): the smallest of the three scales of a taxel.
    """

    noise: float | None
    scale: Floats
    trust: Floats


def weigh(noise: Floats | float | None, shape: tuple[int, int]) -> Weights:
    """Return the weights for a noise of one number or (rows, cols, 3); equal weights for None.

    Raises:
        InputError: noise that does not have the array's shape, or is not positive.
    """
    count = shape[0] * shape[1]
    equal = np.ones((count, 3)), np.ones(count)
    if noise is None:
        return Weights(None, *equal)
    if np.shape(noise) not in ((), (*shape, 3)) or not np.min(noise) > 0:
        wanted = f"positive numbers, one or {(*shape, 3)}, wanted"
        raise InputError(f"noise of shape {np.shape(noise)} from {np.min(noise):g} N on; {wanted}")
    if not np.ndim(noise):
        return Weights(float(noise), *equal)
    sigma = np.reshape(noise, (-1, 3))
    typical = float(np.median(sigma))
    return Weights(typical, typical / sigma, (typical / sigma).min(axis=1))


class TaxelSignals(NamedTuple):
    """Signals of the taxels ``cells`` (n,) of an array of ``shape``: places (n, 2) in depths, signals (n, 3) over the
    largest one times ``scale`` (n, 3), which makes their noise equal.

    ``noise``: its standard deviation, None if unknown; ``layer``: table of `layer_field`; ``tie``: see
    `start_numba.signals`; ``lost``: number of readings left out, whose signal and scale are 0.
    """

    seen: Floats
    measured: Floats
    scale: Floats
    strain: bool
    layer: Floats
    tie: Floats
    cells: Integers
    shape: tuple[int, int]
    noise: float | None
    lost: int = 0

    def without(self, k: int) -> "TaxelSignals":
        """Return the signals of all taxels but the k-th."""
        seen, measured, scale = (np.delete(part, k, 0) for part in (self.seen, self.measured, self.scale))
        lost = self.lost - int((self.scale[k] == 0).sum())
        return self._replace(seen=seen, measured=measured, scale=scale, cells=np.delete(self.cells, k), lost=lost)

    def less(self, readings: Flags) -> "TaxelSignals":
        """Return the signals without these readings (n, 3)."""
        measured, scale = (np.where(readings, 0.0, part) for part in (self.measured, self.scale))
        return self._replace(measured=measured, scale=scale, lost=int((scale == 0).sum()))


def newtons(array: TaxelArray, modulus: float | None) -> float:
    """Return the factor from a signal to newtons: 4 pi E z^2 / 3 of eq. (1), 2 pi z^2 / 3 of eq. (10)."""
    if array.quantity == "strain":
        return 4 * np.pi / 3 * (modulus or 1.0) * array.depth**2
    return 2 * np.pi / 3 * array.depth**2


def fit_floor(array: TaxelArray, dead_band: float) -> float:
    """Return the largest signal of a taxel that is left out of the fit: 0, or ``dead_band`` above a pitch of `SPARSE`.

    A choice of taxels by their signals is biased where noise exceeds the dead band.
    """
    return 0.0 if array.pitch <= SPARSE * array.depth else dead_band


def inverse_program(array: TaxelArray, modulus: float | None, floor: float) -> Program | None:
    """Return the program that locates a load from each taxel alone, from signals above ``floor``; None of forces.

    Raises:
        InputError: strain taxels without the cover's ``modulus`` [Pa].
    """
    if array.quantity == "force":
        return None
    programs = folder() / "programs"  # the shipped ones: users' files of these names do not replace them
    if array.quantity == "stress":
        return load_program(programs / "locate-stress.toml", parameters={"depth": array.depth, "floor": floor})
    if modulus is None:
        raise InputError(
            f"taxel array {array.name!r} measures strain; the cover's Young's modulus is wanted, none is given"
        )
    return load_program(
        programs / "locate-strain.toml", parameters={"depth": array.depth, "modulus": modulus, "floor": floor}
    )
