"""NPZ recordings: NumPy arrays of frames with a header, or PapillArray recordings without one.

``tactile`` is the header, a text in the form of `tactile.core.header`. For every finger s0, s1, ...: ``s0_values``
(frames, rows, cols, 3) in the unit of its quantity; ``s0_valid`` (frames, rows, cols); ``s0_t_s`` and
``s0_t_device_s`` (frames,) [s], NaN where the device has no clock; ``s0_sequence`` (frames,); ``s0_place`` (frames,):
positions of these frames in the recording; and, if a device has flags, ``s0_flags`` (frames,), the bits of
`tactile.core.frame.FLAGS`.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.array_files import open_npz
from tactile.core.frame import MOST_FLAGS, Frame, TaxelArray
from tactile.core.header import header_text, read_header
from tactile.core.source import FrameStream, Source
from tactile.sources.columns import COLUMNS, ColumnFrames, take_column
from tactile.sources.replay_pillars import read_pillars
from tactile.sources.stamps import in_order


def read_npz(path: Path) -> FrameStream:
    """Read a recording: frames with a header, or a PapillArray recording.

    Raises:
        InputError: no such file, no NPZ file, a wrong header, a missing array or one of the wrong shape.
    """
    with open_npz(path, "recording") as file:
        if "tactile" not in file.files or file["tactile"].dtype.kind != "U":
            return read_pillars(file, path)
        header = read_header(str(file["tactile"]), str(path), "array tactile")
        frames = ColumnFrames([_columns(file, n, array, path) for n, array in enumerate(header.arrays)])
    ordered, notes = in_order(list(frames), header.arrays, str(path)) if frames.step_back else (frames, ())
    return replace(header.stream(ordered, len(frames)), notes=notes)


def _columns(file: "np.lib.npyio.NpzFile", number: int, array: TaxelArray, path: Path) -> dict[str, Any]:
    missing = [f"s{number}_{name}" for name in COLUMNS if f"s{number}_{name}" not in file.files]
    if missing:
        raise InputError(f"{path}: {', '.join(missing)} missing, wanted for finger {array.name!r}")
    kinds = COLUMNS | ({"flags": np.int64} if f"s{number}_flags" in file.files else {})
    count = file[f"s{number}_t_s"].shape[:1]
    shapes = {"values": (*count, *array.shape, 3), "valid": (*count, *array.shape)}
    out = {
        name: take_column(file, f"s{number}_{name}", shapes.get(name, count), kind, path)
        for name, kind in kinds.items()
    }
    if "flags" in out and not ((out["flags"] >= 0) & (out["flags"] <= MOST_FLAGS)).all():
        raise InputError(f"{path}: s{number}_flags outside of 0 to {MOST_FLAGS}, bits of flags wanted")
    if not np.isfinite(out["t_s"]).all():
        raise InputError(f"{path}: s{number}_t_s has times that are not finite, finite ones wanted")
    return out


def write_npz(path: Path, source: Source) -> None:
    """Write all frames of a source; reading them back gives the same numbers bit for bit.

    Raises:
        InputError: two fingers have the same name.
        OSError: the file cannot be written.
    """
    out: dict[str, Any] = {"tactile": np.array(header_text(source))}
    fingers: list[list[tuple[int, Frame]]] = [[] for _ in source.arrays]
    for place, frame in enumerate(source):
        fingers[frame.finger].append((place, frame))
    for number, (array, placed) in enumerate(zip(source.arrays, fingers, strict=True)):
        frames = [frame for _, frame in placed]
        columns = {
            "values": [frame.values for frame in frames], "valid": [frame.valid for frame in frames],
            "t_s": [frame.t for frame in frames], "t_device_s": [frame.t_device for frame in frames],
            "sequence": [frame.sequence for frame in frames], "place": [place for place, _ in placed],
        }  # fmt: skip
        shapes = {"values": (-1, *array.shape, 3), "valid": (-1, *array.shape)}
        for name, kind in COLUMNS.items():
            out[f"s{number}_{name}"] = np.array(columns[name], dtype=kind).reshape(shapes.get(name, (-1,)))
        if any(frame.flags for frame in frames):
            out[f"s{number}_flags"] = np.array([frame.flags for frame in frames], dtype=np.int64)
    with path.open("wb") as file:
        np.savez_compressed(file, **out)
