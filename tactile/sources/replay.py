"""Recordings, whatever their file format."""

from collections.abc import Callable
from pathlib import Path

from cnnsim.errors import InputError
from tactile.sources.base import Source
from tactile.sources.replay_csv import read_csv
from tactile.sources.replay_npz import read_npz

READERS: dict[str, Callable[[Path], Source]] = {".csv": read_csv, ".npz": read_npz}


def read_recording(path: Path) -> Source:
    """Read a recording by the reader that its suffix names.

    Raises:
        InputError: an unknown suffix, or what the reader finds wrong.
    """
    if path.suffix.lower() not in READERS:
        raise InputError(f"{path}: suffix {path.suffix!r}, a recording in {' or '.join(READERS)} wanted")
    return READERS[path.suffix.lower()](path)
