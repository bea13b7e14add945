"""Arrays of taxels under point loads, as the scaling study presses them: frames with noise, and the loads located."""

from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter

from cnnsim.support import Floats
from tactile.core.frame import Frame, TaxelArray
from tactile.elastic.halfspace import point_load_strain
from tactile.finger import Finger
from tactile.settings import Settings

MODULUS, DEPTH, PITCH, SIDE = 2.4e6, 1.5e-3, 1.5e-3, 12e-3
"""Young's modulus [Pa], depth [m], pitch [m] at constant pitch, side of the array [m] at constant area."""
FORCE = 0.5
WINDOW = 2.5
"""Half the side of a local window, in depths: at this distance a load's strain is a hundredth of that under it."""


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
    """Return pressing loads on the inner part of an array, at least so many depths from each other."""
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


def place_errors(found: Any, loads: Floats) -> list[float]:
    """Return the distance [m] from each load to the nearest located one; infinity where nothing was located."""
    places = np.array([(load.x, load.y) for load in (found, *found.others) if np.isfinite(load.x)]).reshape(-1, 2)
    if not len(places):
        return [np.inf] * len(loads)
    return [float(np.hypot(*(places - load[:2]).T).min()) for load in loads]


class Windows:
    """Locates loads one by one, each from the taxels in a window around a peak of the normal signal."""

    def __init__(self, array: TaxelArray) -> None:
        self._array, self._reach = array, max(1, int(np.ceil(WINDOW * array.depth / array.pitch)))
        self._fingers: dict[tuple[int, int], Finger] = {}

    def peaks(self, values: Floats) -> list[tuple[int, int]]:
        """Return the taxels that feel most within two depths, above a fifth of the strongest."""
        height = -values[..., 2]
        near = 2 * max(1, int(self._array.depth / self._array.pitch)) + 1
        high = (maximum_filter(height, near) == height) & (height > 0.2 * height.max())
        return [(int(i), int(j)) for i, j in np.argwhere(high)]

    def locate(self, frame: Frame) -> Floats:
        """Return the located loads as places (n, 2) [m]."""
        places = []
        for i, j in self.peaks(frame.values):
            r0, r1 = max(0, i - self._reach), min(self._array.rows, i + self._reach + 1)
            c0, c1 = max(0, j - self._reach), min(self._array.cols, j + self._reach + 1)
            finger = self._finger(r1 - r0, c1 - c0)
            load = finger.locate(Frame(0, 0.0, 0, frame.values[r0:r1, c0:c1], frame.valid[r0:r1, c0:c1]))
            at = self._array.positions()[r0:r1, c0:c1].mean(axis=(0, 1))
            places.append((load.x + at[0], load.y + at[1]))
        found: Floats = np.array(places).reshape(-1, 2)
        return found[np.isfinite(found).all(axis=1)]

    def _finger(self, rows: int, cols: int) -> Finger:
        if (rows, cols) not in self._fingers:
            cut = TaxelArray("window", rows, cols, self._array.pitch, self._array.depth)
            self._fingers[rows, cols] = Finger(cut, MODULUS, Settings())
        return self._fingers[rows, cols]
