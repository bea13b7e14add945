"""Recordings of frames, read by the reader that the suffix names."""

from collections.abc import Callable
from pathlib import Path

from cnnsim.support import InputError
from tactile.core.source import Source
from tactile.sources.replay_csv import read_csv
from tactile.sources.replay_npz import read_npz


def _read_mcap(path: Path) -> Source:
    from tactile.wire.extras import need  # the mcap library comes with an extra

    source: Source = need("tactile.recording.reader", "an MCAP recording").open_recording(path).source()
    return source


READERS: dict[str, Callable[[Path], Source]] = {".csv": read_csv, ".npz": read_npz, ".mcap": _read_mcap}


def read_recording(path: Path) -> Source:
    """Read a recording by the reader that its suffix names.

    Raises:
        InputError: an unknown suffix, or what the reader finds wrong.
    """
    if path.suffix.lower() not in READERS:
        raise InputError(f"{path}: suffix {path.suffix!r}, a recording in {' or '.join(READERS)} wanted")
    return READERS[path.suffix.lower()](path)
