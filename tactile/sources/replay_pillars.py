"""Recordings of PapillArray sensors in NPZ files: forces of pillars, with host and device stamps."""

import math
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.core.frame import Frame, TaxelArray

PILLAR_PITCH = 7e-3
"""Distance of neighbouring pillars of a PapillArray [m]: nominal, the files do not say it."""


@dataclass(frozen=True)
class NpzReplay:
    """A recording read from NPZ, as a ``Source`` of force frames; times count from the earliest host stamp."""

    title: str
    arrays: tuple[TaxelArray, ...]
    force: tuple[Floats, ...]
    host_ns: tuple[Integers, ...]
    sequence: tuple[Integers, ...]
    device_us: tuple[Integers, ...]
    modulus: None = None

    @property
    def frames(self) -> int:
        """Number of frames over all sensors."""
        return sum(stamps.size for stamps in self.host_ns)

    def __iter__(self) -> Iterator[Frame]:
        stamps = np.concatenate(self.host_ns)
        finger = np.repeat(np.arange(len(self.arrays)), [ns.size for ns in self.host_ns])
        index = np.concatenate([np.arange(ns.size) for ns in self.host_ns])
        order = np.argsort(stamps, kind="stable")
        start = stamps[order[0]]
        for f, i, ns in zip(finger[order].tolist(), index[order].tolist(), stamps[order].tolist(), strict=True):
            values = self.force[f][i]
            yield Frame(
                finger=f,
                t=(ns - int(start)) * 1e-9,
                sequence=int(self.sequence[f][i]),
                values=values,
                valid=np.isfinite(values).all(-1),
                t_device=float(self.device_us[f][i]) * 1e-6,
            )


def read_npz(path: Path) -> NpzReplay:
    """Read a recording of one or more sensors s0, s1, ...

    Of every sensor: ``s0_force`` (T, pillars, 3) [N], last axis x, y, z with z positive when pressed, the pillars
    row by row of a square; ``s0_t_ns`` (T,) host stamps [ns]; ``s0_seq`` (T,); ``s0_tus`` (T,) device stamps [us].
    Other arrays in the file are left alone.

    Raises:
        InputError: no such file, no NPZ file, no sensor in it, a missing array or one of the wrong shape.
    """
    try:
        # opened here, since NumPy leaves a file open that turns out to be no archive
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            found = sorted(int(m[1]) for name in file.files if (m := re.fullmatch(r"s(\d+)_force", name)))
            if not found:
                names = ", ".join(file.files) or "nothing"
                raise InputError(f"{path}: holds {names}; s0_force, s0_t_ns, s0_seq, s0_tus wanted")
            sensors = [_read_sensor(file, f"s{number}", str(path)) for number in found]
    except InputError:
        raise
    except (OSError, ValueError, AttributeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as an NPZ recording: {error}") from error
    arrays = tuple(
        TaxelArray(f"sensor {number}", force.shape[1], force.shape[2], PILLAR_PITCH, 0.0, quantity="force")
        for number, (force, *_) in zip(found, sensors, strict=True)
    )
    force, host, sequence, device = zip(*sensors, strict=True)
    return NpzReplay(path.stem, arrays, force, host, sequence, device)


def _read_sensor(file: "np.lib.npyio.NpzFile", name: str, where: str) -> tuple[Floats, Integers, Integers, Integers]:
    """Return (T, side, side, 3) forces, host stamps, sequence numbers, device stamps."""
    for wanted in ("t_ns", "seq", "tus"):
        if f"{name}_{wanted}" not in file.files:
            raise InputError(f"{where}: array {name}_{wanted} is missing beside {name}_force")
    force = np.asarray(file[f"{name}_force"], dtype=np.float64)
    if force.ndim != 3 or force.shape[2] != 3 or not force.shape[0]:
        raise InputError(f"{where}: {name}_force of shape {force.shape}, (frames, pillars, 3) wanted")
    side = math.isqrt(force.shape[1])
    if side == 0 or side * side != force.shape[1]:
        raise InputError(f"{where}: {name}_force has {force.shape[1]} pillars, a square number wanted")
    stamps = []
    for wanted in ("t_ns", "seq", "tus"):
        values = file[f"{name}_{wanted}"]
        if values.shape != force.shape[:1] or not np.issubdtype(values.dtype, np.integer):
            raise InputError(
                f"{where}: {name}_{wanted} of shape {values.shape} and type {values.dtype},"
                f" {force.shape[:1]} whole numbers wanted"
            )
        stamps.append(values.astype(np.int64))
    host, sequence, device = stamps
    return force.reshape(-1, side, side, 3), host, sequence, device
