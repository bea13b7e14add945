"""LeRobotDataset v3.0 of recordings: one episode each, with tared taxels, windows of samples, codes and labels.

Files, as the published format has them: ``data/chunk-000/file-000.parquet`` (one file an episode), ``meta/info.json``,
``meta/stats.json``, ``meta/tasks.parquet``, ``meta/episodes/chunk-000/file-000.parquet``; ``meta/tactile.json`` has the
arrays, their units, the numbers of phases and slips, and each episode's recording, Unix time and first frame.

Source: huggingface/lerobot, ``CODEBASE_VERSION = "v3.0"``.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]  # it ships no types
from pyarrow import parquet

from cnnsim.support import InputError
from cnnsim.support.notices import Notices
from tactile.core.array_table import array_table
from tactile.core.source import provenance
from tactile.export.episode import PHASES, SLIPS, Column, Watch, episode, longest_window
from tactile.export.tared import new_folder
from tactile.layout.layout import Layout
from tactile.sources import is_folder_of_recordings, layout_of, open_source, passed_over, recordings_in

CHUNK = 1000
"""Files per folder."""
PLACE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
INDEX = ("timestamp", "frame_index", "episode_index", "index", "task_index")
NAMES = {1: None, 2: ["taxel", "component"], 3: ["sample", "taxel", "component"]}
"""Names of the dimensions of a feature by their number."""


def write_lerobot(
    source: Path, folder: Path, fps: int, task: str | None, watch: Watch, layout: Path | None = None
) -> tuple[int, int]:  # fmt: skip
    """Write a recording, or each recording of a folder, as an episode; return the numbers of frames and episodes.

    ``task``: text of the task, the title of the first recording unless given; ``layout`` of tables of other programs.

    Raises:
        InputError: no recording, recordings of different arrays, an episode without a tared sample, a taken name.
    """
    known = layout_of(source, layout)
    folder_of = is_folder_of_recordings(source)
    paths = recordings_in(source, known) if folder_of else [source]
    for name, why in passed_over(source, known).items() if folder_of else ():
        Notices.say(f"note: {name}: passed over, {why}")
    if not paths:
        raise InputError(f"{source}: no recordings in it, at least one wanted")
    arrays, window, title = None, 0, ""
    for path in paths:
        opened = open_source(path, known)
        times: list[list[float]] = [[] for _ in opened.arrays]
        for frame in opened:
            times[frame.finger].append(frame.t)
        found = [(array.name, array.shape, array.quantity) for array in opened.arrays]
        if arrays is not None and found != arrays:
            raise InputError(f"{path}: arrays {found}; those of {paths[0]} wanted: {arrays}")
        if not all(times):
            raise InputError(f"{path}: a finger without frames, at least one frame of each wanted")
        arrays, window, title = found, max(window, longest_window(times, fps)), title or opened.title or path.stem
    with new_folder(folder) as made:
        return _write(paths, made, fps, window, (task or title, watch, known)), len(paths)


def _write(paths: list[Path], folder: Path, fps: int, window: int, more: tuple[str, Watch, Layout | None]) -> int:
    task, watch, layout = more
    rows: list[dict[str, Any]] = []
    stats: list[dict[str, Any]] = []
    origin, features, total = [], dict[str, Any](), 0
    for number, path in enumerate(paths):
        columns, first = episode(path, fps, window, watch, layout)
        count = len(next(iter(columns.values())))
        frame = np.arange(count)
        index = ((frame / fps).astype(np.float32), frame, np.full(count, number), total + frame, np.zeros(count, int))
        columns |= dict(zip(INDEX, index, strict=True))
        features = {name: _feature(name, column) for name, column in columns.items()}
        place = {"chunk_index": number // CHUNK, "file_index": number % CHUNK}
        _table({name: _nested(column) for name, column in columns.items()}, folder / "data" / PLACE.format(**place))
        stats.append({name: _stats(column) for name, column in columns.items()})
        rows.append({
            "episode_index": number, "tasks": [task], "length": count, "dataset_from_index": total,
            "dataset_to_index": total + count, **{f"data/{name}": at for name, at in place.items()},
            "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
            **{f"stats/{name}/{kind}": one for name, of in stats[-1].items() for kind, one in of.items()},
        })  # fmt: skip
        start = provenance(open_source(path, layout)).start_ns
        unix = None if start is None else start + round(first * 1e9)
        origin.append({"recording": path.name, "first_frame_s": first, "start_ns": start, "first_frame_ns": unix})
        total += count
    info = {
        "codebase_version": "v3.0", "robot_type": None, "total_episodes": len(rows), "total_frames": total,
        "total_tasks": 1, "chunks_size": CHUNK, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200, "fps": fps,
        "splits": {"train": f"0:{len(rows)}"}, "data_path": f"data/{PLACE}", "video_path": None, "features": features,
    }  # fmt: skip
    about = {
        "arrays": [array_table(array, "m") for array in open_source(paths[0], layout).arrays], "phases": PHASES,
        "slips": SLIPS, "episodes": origin,
    }  # fmt: skip
    _table({name: pa.array([row[name] for row in rows]) for name in rows[0]},
           folder / "meta" / "episodes" / PLACE.format(chunk_index=0, file_index=0))  # fmt: skip
    _tasks(folder / "meta" / "tasks.parquet", task)
    for name, data in (("info", info), ("stats", _together(stats)), ("tactile", about)):
        (folder / "meta" / f"{name}.json").write_text(json.dumps(data, indent=4), encoding="utf-8")
    return total


def _feature(name: str, column: Column) -> dict[str, Any]:
    """Return the entry of a feature in info.json; a scalar has the shape (1,)."""
    shape = list(column.shape[1:]) or [1]
    return {"dtype": str(column.dtype), "shape": shape, "names": NAMES[len(shape)]}


def _nested(column: Column) -> Any:
    """Return an array (n, ...) as nested lists of Arrow; (n, 1) as scalars, as the format has them."""
    flat = column[:, 0] if column.ndim == 2 and column.shape[1] == 1 else column
    made = pa.array(flat.reshape(-1))
    for depth in range(flat.ndim - 1, 0, -1):
        size = flat.shape[depth]
        made = pa.ListArray.from_arrays(np.arange(0, len(made) + 1, size, dtype=np.int32), made)
    return made


def _stats(column: Column) -> dict[str, Any]:
    values = column.astype(np.float64)
    found = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    found |= {
        f"q{round(100 * q):02d}": one for q, one in zip(QUANTILES, np.quantile(values, QUANTILES, 0), strict=True)
    }
    return {name: np.atleast_1d(one).tolist() for name, one in found.items()} | {"count": [len(values)]}


def _together(episodes: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the statistics of all episodes; quantiles are means weighted by frames, as the format has them."""
    found: dict[str, Any] = {}
    for name in episodes[0]:
        count = np.array([one[name]["count"][0] for one in episodes])
        of = {kind: np.array([one[name][kind] for one in episodes]) for kind in episodes[0][name]}
        weighted = {kind: np.average(each, 0, count) for kind, each in of.items()}
        spread = np.average(of["std"] ** 2 + (of["mean"] - weighted["mean"]) ** 2, 0, count)
        exact = {"min": of["min"].min(0), "max": of["max"].max(0), "std": np.sqrt(spread), "count": count.sum()[None]}
        found[name] = {kind: each.tolist() for kind, each in (weighted | exact).items()}
    return found


def _tasks(path: Path, task: str) -> None:
    """Write the table of tasks; its index, for pandas, is the text of the task."""
    columns = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": of, "metadata": None}
        for name, kind, of in (("task_index", "int64", "int64"), ("task", "unicode", "object"))
    ]
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": columns, "pandas_version": "2.0.0"}
    _table({"task_index": pa.array([0]), "task": pa.array([task])}, path, {"pandas": json.dumps(pandas)})


def _table(columns: Mapping[str, Any], path: Path, metadata: dict[str, str] | None = None) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pa.table(dict(columns)).replace_schema_metadata(metadata), path)
