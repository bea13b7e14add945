"""Conversion of recordings and scenes into CSV, NPZ, Parquet and MCAP."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.own_file import written_beside
from tactile.core.frame import Frame
from tactile.core.source import FrameStream, Source
from tactile.sources import open_source
from tactile.sources.replay_csv import write_csv
from tactile.wire.extras import need


def open_any(path: Path) -> Source:
    """Return the frames of a recording (.mcap, .npz, .csv), a ROS bag (.bag, or a folder) or a scene (.toml).

    Raises:
        InputError: no such file, or what its reader finds wrong.
    """
    if path.suffix in (".bag", ".db3") or path.is_dir():
        bag: Source = need("tactile.sources.replay_rosbag", "a ROS bag").read_bag(path)
        return bag
    return open_source(path)


def convert(source: Path, target: Path, overwrite: bool = False) -> int:
    """Write the frames of ``source`` as ``target``, in the form its suffix names, and return how many there were.

    Nothing is there under that name until all is written.

    Raises:
        InputError: an unknown suffix, a name that is taken (unless to ``overwrite``), a full disk, or what reader or
            writer find wrong.
    """
    if target.suffix not in WRITERS:
        raise InputError(f"{target}: suffix {target.suffix!r}, one of {', '.join(WRITERS)} wanted")
    if target.exists() and target.samefile(source):
        raise InputError(f"{target} is the recording itself; another name wanted")
    opened, count = open_any(source), 0

    def counted() -> Iterator[Frame]:
        nonlocal count
        for frame in opened:
            count += 1
            yield frame

    try:
        with written_beside(target, overwrite) as beside:
            if target.suffix == ".mcap" and source.suffix == ".mcap":
                need("tactile.recording.index", "an MCAP recording").write_indexed(source, beside)
                return sum(1 for _ in opened)
            frames = FrameStream(opened.title, opened.arrays, opened.modulus, opened.frames, counted())
            WRITERS[target.suffix](beside, frames)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror or error}") from error
    return count


def _npz(path: Path, source: Source) -> None:
    """Write the layout that `tactile.sources.replay_npz` reads: s0_force (frames, taxels, 3), s0_t_ns, s0_seq, s0_tus.

    Arrays of another quantity than force are named after it; where the device has no clock, s0_tus is -1.
    """
    fingers: dict[int, list[Frame]] = {}
    for frame in source:
        fingers.setdefault(frame.finger, []).append(frame)
    out: dict[str, Any] = {}
    for finger, frames in sorted(fingers.items()):
        name = f"s{finger}"
        values = [np.where(frame.valid[..., None], frame.values, np.nan).reshape(-1, 3) for frame in frames]
        device = np.array([frame.t_device for frame in frames])
        out[f"{name}_{source.arrays[finger].quantity}"] = np.array(values)
        out[f"{name}_t_ns"] = np.array([round(frame.t * 1e9) for frame in frames])
        out[f"{name}_seq"] = np.array([frame.sequence for frame in frames])
        out[f"{name}_tus"] = np.where(np.isfinite(device), np.rint(np.nan_to_num(device) * 1e6), -1).astype(np.int64)
    np.savez_compressed(path, **out)


def _parquet(path: Path, source: Source) -> None:
    """Write one row a frame: t_s, t_device_s, finger, sequence, and the values as a list, NaN where not valid."""
    pa, parquet = need("pyarrow", "a Parquet file"), need("pyarrow.parquet", "a Parquet file")
    shapes = {array.name: f"{array.rows}x{array.cols} {array.quantity}" for array in source.arrays}
    columns = pa.schema(
        [("t_s", pa.float64()), ("t_device_s", pa.float64()), ("finger", pa.string()), ("sequence", pa.int64()),
         ("values", pa.list_(pa.float64()))], metadata={"title": source.title, **shapes},
    )  # fmt: skip
    with parquet.ParquetWriter(path, columns) as out:
        rows: list[dict[str, Any]] = []
        for frame in source:
            values = np.where(frame.valid[..., None], frame.values, np.nan).ravel()
            rows.append({"t_s": frame.t, "t_device_s": frame.t_device, "finger": source.arrays[frame.finger].name,
                         "sequence": frame.sequence, "values": values})  # fmt: skip
            if len(rows) == 4096:
                out.write_batch(pa.RecordBatch.from_pylist(rows, columns))
                rows = []
        if rows:
            out.write_batch(pa.RecordBatch.from_pylist(rows, columns))


def _mcap(path: Path, source: Source) -> None:
    need("tactile.recording.index", "an MCAP recording").write_frames(path, source)


WRITERS: dict[str, Callable[[Path, Source], None]] = {
    ".csv": write_csv, ".npz": _npz, ".parquet": _parquet, ".mcap": _mcap,
}  # fmt: skip
