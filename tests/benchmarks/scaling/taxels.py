"""Arrays of taxels under random point loads: frames with noise for the scaling study."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import Frame, TaxelArray
from tactile.elastic.halfspace import point_load_strain

MODULUS, DEPTH, PITCH, SIDE = 2.4e6, 1.5e-3, 1.5e-3, 12e-3
"""Young's modulus [Pa], depth [m], pitch [m] at constant pitch, side of the array [m] at constant area."""
FORCE = 0.5


def array_of(side: int, pitch: float = PITCH, depth: float = DEPTH) -> TaxelArray:
    """Return a square array."""
    return TaxelArray("pad", side, side, pitch, depth)


def frame_of(array: TaxelArray, loads: Floats, noise: float, random: np.random.Generator) -> Frame:
    """Return a frame under point loads (n, 5), with noise relative to the strongest signal."""
    values = np.zeros((*array.shape, 3))
    for part in np.array_split(np.arange(array.rows), max(1, array.rows // 64)):  # all loads on 64 rows at a time
        values[part] = point_load_strain(array.positions()[part], array.depth, loads, MODULUS)
    values += noise * np.abs(values).max() * random.standard_normal(values.shape)
    return Frame(0, 0.0, 0, values, np.ones(array.shape, bool))


def random_loads(array: TaxelArray, count: int, apart: float, random: np.random.Generator) -> Floats:
    """Return pressing loads on the inner part of an array, with a least distance in depths."""
    half = max(0.5 * array.pitch, array.pitch * (array.cols - 1) / 2 - array.depth)
    places: list[Floats] = []
    for _ in range(10_000):
        place = random.uniform(-half, half, 2)
        if all(np.hypot(*(place - other)) >= apart * array.depth for other in places):
            places.append(place)
        if len(places) == count:
            break
    loads = np.zeros((len(places), 5))
    loads[:, :2], loads[:, 2:4] = places, random.uniform(-0.1, 0.1, (len(places), 2))
    loads[:, 4] = FORCE * random.uniform(0.7, 1.3, len(places))
    return loads
