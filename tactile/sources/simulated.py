"""Scenes: point loads that move over the fingers' covers, and the frames the taxels would give."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.errors import InputError
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.frame import Frame, TaxelArray
from tactile.sources.tables import check_keys, numbers, take, take_array, take_numbers, take_tables

CHUNK = 1024
"""Frames computed at once."""
TOP_KEYS = ("title", "rate_hz", "duration_s", "cover", "finger", "load")
COVER_KEYS = ("youngs_modulus_mpa", "quantity")
FINGER_KEYS = ("name", "rows", "cols", "pitch_mm", "depth_mm", "origin_mm")
LOAD_KEYS = ("finger", "path")
KEYFRAME = "t_s, x_mm, y_mm, Q_N, R_N, F_N"


@dataclass(frozen=True)
class MovingLoad:
    """A point load on one finger: ``path`` (n, 6), rows (t, x, y, Q, R, F) [s, m, m, N, N, N], t growing.

    Between its rows it changes linearly; before the first and after the last it is not there. With one row it
    stands still from that time on.
    """

    finger: int
    path: NDArray[np.float64]

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return rows (x, y, Q, R, F) [m, N] at the times [s], without force where the load is absent."""
        rows = np.stack([np.interp(times, self.path[:, 0], column) for column in self.path[:, 1:].T], axis=-1)
        gone = times < self.path[0, 0]
        if len(self.path) > 1:
            gone |= times > self.path[-1, 0]
        rows[gone, 2:] = 0
        return rows


@dataclass(frozen=True)
class Scene:
    """A simulated recording, as a ``Source``: every finger is sampled at the times k / rate, k = 0, 1, ...

    ``rate`` [Hz], ``duration`` [s], ``modulus`` Young's modulus of the cover [Pa]. Loads on one finger add.
    """

    title: str
    rate: float
    duration: float
    modulus: float
    arrays: tuple[TaxelArray, ...]
    loads: tuple[MovingLoad, ...]

    @property
    def frames(self) -> int:
        """Number of frames over all fingers."""
        return self.samples * len(self.arrays)

    @property
    def samples(self) -> int:
        """Number of frames of each finger."""
        return max(1, round(self.rate * self.duration))

    def loads_at(self, finger: int, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (times, loads, 5) rows (x, y, Q, R, F) on a finger: what a localiser should find."""
        paths = [load.at(times) for load in self.loads if load.finger == finger]
        return np.stack(paths, axis=1) if paths else np.empty((times.size, 0, 5))

    def __iter__(self) -> Iterator[Frame]:
        for start in range(0, self.samples, CHUNK):
            count = np.arange(start, min(start + CHUNK, self.samples))
            times = count / self.rate
            signals = [self._signals(finger, times) for finger in range(len(self.arrays))]
            for k, t in enumerate(times.tolist()):
                for finger, values in enumerate(signals):
                    valid = np.ones(values.shape[1:3], bool)
                    yield Frame(finger, t, start + k, values[k], valid)

    def _signals(self, finger: int, times: NDArray[np.float64]) -> NDArray[np.float64]:
        array = self.arrays[finger]
        loads = self.loads_at(finger, times)[:, None, None]
        if array.quantity == "stress":
            return point_load_stress(array.positions(), array.depth, loads)
        return point_load_strain(array.positions(), array.depth, loads, self.modulus)


def read_scene(path: Path) -> Scene:
    """Read a scene from a TOML file; ``examples/scenes/grip.toml`` explains every key.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a wrong type or value, no loads.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a scene: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not TOML: {error}") from error
    return scene_from(table, str(path))


def scene_from(table: dict[str, Any], where: str) -> Scene:
    """Return the scene that a parsed TOML table describes; ``where`` names it in messages.

    Raises:
        InputError: as ``read_scene``.
    """
    check_keys(table, TOP_KEYS, where)
    cover = take(table, "cover", dict, where)
    check_keys(cover, COVER_KEYS, f"{where}: [cover]")
    modulus = _positive(cover, "youngs_modulus_mpa", f"{where}: [cover]") * 1e6
    quantity = take(cover, "quantity", str, f"{where}: [cover]", "strain")
    if quantity not in ("strain", "stress"):
        raise InputError(f"{where}: [cover]: quantity = {quantity!r}, 'strain' or 'stress' wanted")
    fingers = take_tables(table, "finger", where)
    arrays = tuple(_finger(finger, quantity, f"{where}: finger {n}") for n, finger in enumerate(fingers, 1))
    names = [array.name for array in arrays]
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    loads = take_tables(table, "load", where)
    if not loads:
        raise InputError(f"{where}: a scene without loads, at least one [[load]] wanted")
    return Scene(
        title=take(table, "title", str, where),
        rate=_positive(table, "rate_hz", where),
        duration=_positive(table, "duration_s", where),
        modulus=modulus,
        arrays=arrays,
        loads=tuple(_load(load, names, f"{where}: load {n}") for n, load in enumerate(loads, 1)),
    )


def _finger(table: dict[str, Any], quantity: str, where: str) -> TaxelArray:
    check_keys(table, FINGER_KEYS, where)
    return take_array(
        table,
        pitch=take(table, "pitch_mm", float, where) * 1e-3,
        depth=take(table, "depth_mm", float, where) * 1e-3,
        origin=[x * 1e-3 for x in take_numbers(table, "origin_mm", 2, where, [0.0, 0.0])],
        quantity=quantity,
        where=where,
    )


def _load(table: dict[str, Any], names: list[str], where: str) -> MovingLoad:
    check_keys(table, LOAD_KEYS, where)
    name = take(table, "finger", str, where)
    if name not in names:
        raise InputError(f"{where}: finger = {name!r}, one of {', '.join(names)} wanted")
    rows = take(table, "path", list, where)
    if not rows:
        raise InputError(f"{where}: path has no keyframe, at least one [{KEYFRAME}] wanted")
    path = np.array([numbers(row, 6, f"{where}: keyframe [{KEYFRAME}] {n}") for n, row in enumerate(rows, 1)])
    for n, (before, after) in enumerate(zip(path[:-1, 0].tolist(), path[1:, 0].tolist(), strict=True), 2):
        if after <= before:
            raise InputError(f"{where}: keyframe {n} at t_s = {after} after {before}, growing times wanted")
    return MovingLoad(names.index(name), path * (1, 1e-3, 1e-3, 1, 1, 1))


def _positive(table: dict[str, Any], key: str, where: str) -> float:
    value = take(table, key, float, where)
    if value <= 0:
        raise InputError(f"{where}: {key} = {value}, a positive number wanted")
    return value
