"""Frames in columns: for every finger one array of each quantity over all its frames."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from tactile.core.frame import Frame

COLUMNS = {
    "values": np.float64, "valid": np.bool_, "t_s": np.float64, "t_device_s": np.float64, "sequence": np.int64,
    "place": np.int64,
}  # fmt: skip
"""Name and type of every column; ``flags`` is optional."""


class ColumnFrames:
    """Frames from the columns of each finger, in the order of their ``place``; iterable repeatedly."""

    def __init__(self, fingers: Sequence[dict[str, Any]]) -> None:
        self._fingers = fingers

    def __len__(self) -> int:
        return sum(finger["t_s"].size for finger in self._fingers)

    @property
    def step_back(self) -> bool:
        """Whether a time is earlier than that of the frame before."""
        place, t = (np.concatenate([finger[name] for finger in self._fingers]) for name in ("place", "t_s"))
        return bool((np.diff(t[np.argsort(place, kind="stable")]) < 0).any())

    def __iter__(self) -> Iterator[Frame]:
        place = np.concatenate([finger["place"] for finger in self._fingers])
        number = np.repeat(np.arange(len(self._fingers)), [finger["t_s"].size for finger in self._fingers])
        index = np.concatenate([np.arange(finger["t_s"].size) for finger in self._fingers])
        order = np.argsort(place, kind="stable")
        for f, i in zip(number[order].tolist(), index[order].tolist(), strict=True):
            of = self._fingers[f]
            t, device = float(of["t_s"][i]), float(of["t_device_s"][i])
            flags = int(of["flags"][i]) if "flags" in of else 0
            yield Frame(f, t, int(of["sequence"][i]), of["values"][i], of["valid"][i], device, flags)


def take_column(file: "np.lib.npyio.NpzFile", name: str, shape: tuple[int, ...], kind: Any, path: Path) -> Any:
    """Return an array of an NPZ file as ``kind``.

    Raises:
        InputError: another shape, or a type that is not of this kind.
    """
    values = file[name]
    if values.shape != shape or not np.can_cast(values.dtype, kind, "same_kind"):
        found = f"shape {values.shape} and type {values.dtype}"
        raise InputError(f"{path}: {name} of {found}, {shape} of {np.dtype(kind)} wanted")
    return values.astype(kind, copy=False)
