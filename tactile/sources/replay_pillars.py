"""PapillArray recordings in NPZ files without a header: forces of pillars, host and device stamps."""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from tactile.core.frame import FLAGS, TaxelArray
from tactile.core.source import ForeignFileError, FrameStream, Provenance
from tactile.sources.columns import ColumnFrames, take_column
from tactile.sources.stamps import counted, settled

PILLAR_PITCH = 7e-3
"""Nominal distance of neighbouring pillars of a PapillArray [m]; files do not have it."""
STAMPS = ("t_ns", "seq", "tus")


@dataclass(frozen=True, repr=False)
class PillarStream(FrameStream):
    """Force frames of PapillArray sensors; times count from the earliest host stamp.

    ``others``: names of the contents of the file that are ignored.
    """

    others: tuple[str, ...] = ()


def pillar_array(name: str, pillars: int, where: str) -> TaxelArray:
    """Return the array of a sensor; ``where`` leads the message.

    Raises:
        InputError: the pillars are no square.
    """
    side = math.isqrt(pillars)
    if side == 0 or side * side != pillars:
        raise InputError(f"{where} has {pillars} pillars, a square number wanted")
    return TaxelArray(name, side, side, PILLAR_PITCH, 0.0, quantity="force")


def read_pillars(file: "np.lib.npyio.NpzFile", path: Path) -> PillarStream:
    """Read a recording of one or more sensors s0, s1, ...

    Of every sensor: ``s0_force`` (T, pillars, 3) [N], last axis x, y, z with z positive when pressed, the pillars
    row by row of a square; ``s0_t_ns`` (T,) host stamps [ns]; ``s0_seq`` (T,); ``s0_tus`` (T,) device stamps [us];
    and where there are any ``s0_flags`` (T, 3): slip detection on, reference loaded, contact.
    Other arrays in the file are ignored.

    Raises:
        InputError: no sensor in it, a missing array or one of the wrong shape.
    """
    found = sorted(int(m[1]) for name in file.files if (m := re.fullmatch(r"s(\d+)_force", name)))
    if not found:
        names = ", ".join(file.files) or "nothing"
        raise ForeignFileError(f"{path}: holds {names}; s0_force, s0_t_ns, s0_seq, s0_tus wanted")
    arrays, fingers, notes = zip(*(_read_sensor(file, number, path) for number in found), strict=True)
    start = min(int(columns["place"].min()) for columns in fingers)
    for columns in fingers:
        columns["t_s"] = (columns["place"] - start) * 1e-9
    frames = ColumnFrames(fingers)
    read = {f"s{number}_{name}" for number in found for name in ("force", *STAMPS, "flags")}
    others = tuple(name for name in file.files if name not in read)
    known = Provenance(untared=True, start_ns=start)
    return PillarStream(
        path.stem, arrays, None, len(frames), frames, known, notes=tuple(filter(None, notes)), others=others
    )


def _read_sensor(file: "np.lib.npyio.NpzFile", number: int, path: Path) -> tuple[TaxelArray, dict[str, Any], str]:
    """Return the array of a sensor, its columns without ``t_s``, and a note; ``place`` is the host stamp [ns].

    Host stamps with a fault are replaced by the device's clock or the sequence numbers.
    """
    name = f"s{number}"
    for wanted in STAMPS:
        if f"{name}_{wanted}" not in file.files:
            raise InputError(f"{path}: array {name}_{wanted} is missing; it belongs to {name}_force")
    force = np.asarray(file[f"{name}_force"], dtype=np.float64)
    if force.ndim != 3 or force.shape[2] != 3 or not force.shape[0]:
        raise InputError(f"{path}: {name}_force of shape {force.shape}, (frames, pillars, 3) wanted")
    array = pillar_array(f"sensor-{number}", force.shape[1], f"{path}: {name}_force")
    values, count = force.reshape(-1, *array.shape, 3), force.shape[:1]
    host, sequence, device = (take_column(file, f"{name}_{one}", count, np.int64, path) for one in STAMPS)
    seconds, clock = (host - host[0]) * 1e-9, (device - device[0]) * 1e-6
    others = {"the device": clock, "the sequence numbers": counted(sequence.astype(np.float64), seconds)}
    times, note = settled(seconds, others, f"{path}: stamps {name}_t_ns")
    if note:
        host = host[0] + np.round(times * 1e9).astype(np.int64)
    columns = {
        "values": values, "valid": np.isfinite(values).all(-1), "t_device_s": device * 1e-6, "sequence": sequence,
        "place": host,
    }  # fmt: skip
    if f"{name}_flags" in file.files:
        flags = take_column(file, f"{name}_flags", (*count, len(FLAGS)), np.int64, path)
        columns["flags"] = (flags != 0).astype(np.int64) @ np.array(list(FLAGS.values()))
    return array, columns, note
