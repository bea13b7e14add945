"""PapillArray recordings in NPZ files without a header: forces of pillars, host and device stamps."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.core.frame import FLAGS, Frame, TaxelArray
from tactile.core.source import Provenance

PILLAR_PITCH = 7e-3
"""Nominal distance of neighbouring pillars of a PapillArray [m]; files do not have it."""
STAMPS = ("t_ns", "seq", "tus")


@dataclass(frozen=True)
class PillarReplay:
    """A PapillArray recording as a ``Source`` of force frames; times count from the earliest host stamp.

    ``others``: names of the arrays of the file that are ignored.
    """

    title: str
    arrays: tuple[TaxelArray, ...]
    force: tuple[Floats, ...]
    host_ns: tuple[Integers, ...]
    sequence: tuple[Integers, ...]
    device_us: tuple[Integers, ...]
    flags: tuple[Integers, ...] = ()
    others: tuple[str, ...] = ()
    modulus: None = None

    @property
    def frames(self) -> int:
        """Number of frames over all sensors."""
        return sum(stamps.size for stamps in self.host_ns)

    @property
    def provenance(self) -> Provenance:
        """Readings of a device, with its offsets."""
        return Provenance(untared=True, start_ns=min(int(stamps.min()) for stamps in self.host_ns))

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
                flags=int(self.flags[f][i]) if self.flags else 0,
            )


def read_pillars(file: "np.lib.npyio.NpzFile", path: Path) -> PillarReplay:
    """Read a recording of one or more sensors s0, s1, ...

    Of every sensor: ``s0_force`` (T, pillars, 3) [N], last axis x, y, z with z positive when pressed, the pillars
    row by row of a square; ``s0_t_ns`` (T,) host stamps [ns]; ``s0_seq`` (T,); ``s0_tus`` (T,) device stamps [us];
    and where there are any ``s0_flags`` (T, 3): slip detection on, reference loaded, contact.
    Other arrays in the file are left alone.

    Raises:
        InputError: no sensor in it, a missing array or one of the wrong shape.
    """
    found = sorted(int(m[1]) for name in file.files if (m := re.fullmatch(r"s(\d+)_force", name)))
    if not found:
        names = ", ".join(file.files) or "nothing"
        raise InputError(f"{path}: holds {names}; s0_force, s0_t_ns, s0_seq, s0_tus wanted")
    sensors = [_read_sensor(file, f"s{number}", str(path)) for number in found]
    arrays = tuple(
        TaxelArray(f"sensor-{number}", force.shape[1], force.shape[2], PILLAR_PITCH, 0.0, quantity="force")
        for number, (force, *_) in zip(found, sensors, strict=True)
    )
    force, host, sequence, device, flags = zip(*sensors, strict=True)
    read = {f"s{number}_{name}" for number in found for name in ("force", *STAMPS, "flags")}
    others = tuple(name for name in file.files if name not in read)
    return PillarReplay(path.stem, arrays, force, host, sequence, device, flags, others)


def _read_sensor(
    file: "np.lib.npyio.NpzFile", name: str, where: str
) -> tuple[Floats, Integers, Integers, Integers, Integers]:
    """Return (T, side, side, 3) forces, host stamps, sequence numbers, device stamps, flags."""
    for wanted in STAMPS:
        if f"{name}_{wanted}" not in file.files:
            raise InputError(f"{where}: array {name}_{wanted} is missing beside {name}_force")
    force = np.asarray(file[f"{name}_force"], dtype=np.float64)
    if force.ndim != 3 or force.shape[2] != 3 or not force.shape[0]:
        raise InputError(f"{where}: {name}_force of shape {force.shape}, (frames, pillars, 3) wanted")
    side = math.isqrt(force.shape[1])
    if side == 0 or side * side != force.shape[1]:
        raise InputError(f"{where}: {name}_force has {force.shape[1]} pillars, a square number wanted")
    stamps = []
    for wanted in STAMPS:
        values = file[f"{name}_{wanted}"]
        if values.shape != force.shape[:1] or not np.issubdtype(values.dtype, np.integer):
            raise InputError(
                f"{where}: {name}_{wanted} of shape {values.shape} and type {values.dtype},"
                f" {force.shape[:1]} whole numbers wanted"
            )
        stamps.append(values.astype(np.int64))
    host, sequence, device = stamps
    return force.reshape(-1, side, side, 3), host, sequence, device, _flags(file, name, force.shape[0], where)


def _flags(file: "np.lib.npyio.NpzFile", name: str, frames: int, where: str) -> Integers:
    """Return (T,) the flags of the device, as `tactile.core.frame.FLAGS`; 0 if the file has none."""
    if f"{name}_flags" not in file.files:
        return np.zeros(frames, np.int64)
    flags = file[f"{name}_flags"]
    if flags.shape != (frames, len(FLAGS)) or not np.issubdtype(flags.dtype, np.integer):
        found = f"{where}: {name}_flags of shape {flags.shape} and type {flags.dtype}"
        raise InputError(f"{found}, {(frames, len(FLAGS))} whole numbers wanted")
    whole: Integers = (flags != 0).astype(np.int64) @ np.array(list(FLAGS.values()))
    return whole
