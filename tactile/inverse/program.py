"""The per-cell inverse of an array: its analytic program, and what its signals are counted in."""

import numpy as np

from cnnsim import InputError
from cnnsim.library.folders import folder
from cnnsim.program.file import load_program
from cnnsim.program.program import Program
from tactile.core.frame import TaxelArray


def newtons(array: TaxelArray, modulus: float | None) -> float:
    """Return what `localise` multiplies a signal with: eqs (1) and (10) in depths and newtons."""
    if array.quantity == "strain":
        return 4 * np.pi / 3 * (modulus or 1.0) * array.depth**2
    return 2 * np.pi / 3 * array.depth**2


def inverse_program(array: TaxelArray, modulus: float | None, floor: float) -> Program | None:
    """Return the program that locates a load from each taxel alone, from signals above ``floor``; None of forces.

    Raises:
        InputError: strain taxels without the cover's ``modulus`` [Pa].
    """
    if array.quantity == "force":
        return None
    programs = folder() / "programs"  # as they came: users' files of these names replace them nowhere
    if array.quantity == "stress":
        return load_program(programs / "locate-stress.toml", parameters={"depth": array.depth, "floor": floor})
    if modulus is None:
        raise InputError(
            f"taxel array {array.name!r} measures strain; the cover's Young's modulus is wanted, none is given"
        )
    return load_program(
        programs / "locate-strain.toml", parameters={"depth": array.depth, "modulus": modulus, "floor": floor}
    )
