"""Opening a source of frames: a scene, a recording or a ROS bag."""

from collections.abc import Callable
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.files import named_file
from tactile.core.source import Source
from tactile.wire.extras import need

KINDS = (".toml", ".npz", ".csv", ".parquet", ".mcap", ".bag", ".db3")
"""Suffixes of sources; the folder of a ROS 2 bag is a source, too."""


def open_source(path: Path | str) -> Source:
    """Return the source in a file: a scene (.toml), a recording (.npz, .csv, .parquet, .mcap) or a ROS bag.

    A ROS bag is a .bag file, a .db3 file or the folder of a ROS 2 bag.

    Raises:
        InputError: no path; a missing file, an unknown suffix, or invalid contents.
    """
    path = named_file(path)
    suffix = ".bag" if path.is_dir() else path.suffix.lower()
    if not path.exists():
        raise InputError(f"no scene or recording {path}")
    if path.is_dir() and not is_bag(path):
        raise InputError(f"{path}: a folder, and no ROS bag (no metadata.yaml in it); a scene or recording wanted")
    if suffix not in KINDS:
        raise InputError(f"{path}: suffix {path.suffix!r}, a scene or recording in {', '.join(KINDS)} wanted")
    return _READERS[suffix](path)


def is_bag(folder: Path) -> bool:
    """Return whether a folder is a ROS 2 bag."""
    return (folder / "metadata.yaml").is_file()


def _read_scene(path: Path) -> Source:
    from tactile.simulator.scene_file.file import read_scene  # imported when used

    return read_scene(path)


def _read_csv(path: Path) -> Source:
    from tactile.sources.replay_csv import read_csv  # imported when used

    return read_csv(path)


def _read_npz(path: Path) -> Source:
    from tactile.sources.replay_npz import read_npz  # imported when used

    return read_npz(path)


def _read_parquet(path: Path) -> Source:
    source: Source = need("tactile.sources.replay_parquet", "a Parquet file").read_parquet(path)
    return source


def _read_mcap(path: Path) -> Source:
    source: Source = need("tactile.recording.reader", "an MCAP recording").open_recording(path).source()
    return source


def _read_bag(path: Path) -> Source:
    source: Source = need("tactile.sources.replay_rosbag", "a ROS bag").read_bag(path)
    return source


_READERS: dict[str, Callable[[Path], Source]] = {
    ".toml": _read_scene, ".npz": _read_npz, ".csv": _read_csv, ".parquet": _read_parquet, ".mcap": _read_mcap,
    ".bag": _read_bag, ".db3": _read_bag,
}  # fmt: skip
