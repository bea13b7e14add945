"""Taxel arrays in a half-space, their signals under loads, and located loads."""

from typing import Any

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.load import Load
from tactile.inverse.localise import localise
from tactile.inverse.taxel import invert_strain, invert_stress

DEPTH = 1.5e-3
PITCH = 1.5e-3
MODULUS = 2.4e6
SCALE = np.array([DEPTH, DEPTH, 1.0, 1.0, 1.0])


def array(rows: int, cols: int) -> Floats:
    return TaxelArray("left", rows, cols, PITCH, DEPTH, origin=(4e-3, -2e-3)).positions()


def locate(at: Floats, strain: Any, noise: float | Floats | None = None, saturated: Flags | None = None) -> Load:
    x, y, z = np.moveaxis(np.asarray(strain), -1, 0)
    pressing, pulling = (invert_strain(x, y, z, DEPTH, MODULUS, 0.0, sign) for sign in (1, -1))
    return localise(at, pressing, pulling, DEPTH, noise, saturated)


def as_row(load: Load) -> tuple[float, ...]:
    return load.x, load.y, load.Q, load.R, load.F


def random_load(random: np.random.Generator, rows: int, cols: int) -> Floats:
    half = np.array([cols, rows]) * PITCH / 2
    place = np.array([4e-3, -2e-3]) + random.uniform(-half, half)
    return np.concatenate([place, random.normal(size=3)])


def measured(at: Floats, loads: Any, stress: bool) -> Floats:
    return point_load_stress(at, DEPTH, loads) if stress else point_load_strain(at, DEPTH, loads, MODULUS)


def found(
    at: Floats, signals: Floats, stress: bool, noise: float | Floats | None = None, saturated: Flags | None = None
) -> Load:
    """Locate one load from signals; ``noise`` is in the unit of the signals."""
    if not stress:
        return locate(at, signals, None if noise is None else noise * 4 * np.pi / 3 * MODULUS * DEPTH**2, saturated)
    x, y, z = np.moveaxis(signals, -1, 0)
    planes = invert_stress(x, y, z, DEPTH, 0.0)
    return localise(at, planes, None, DEPTH, None if noise is None else noise * 2 * np.pi / 3 * DEPTH**2, saturated)
