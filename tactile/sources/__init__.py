"""Opening a source of frames: a scene or a recording."""

from collections.abc import Callable
from pathlib import Path

from cnnsim.support import InputError
from tactile.core.source import Source
from tactile.wire.extras import need


def open_source(path: Path | str) -> Source:
    """Return the source that a file is: a scene (.toml) or a recording (.npz, .csv, .mcap).

    Raises:
        InputError: the file is missing, of no known kind, or wrong inside.
    """
    from tactile.simulator.scene.file import read_scene  # only with a source are these wanted
    from tactile.sources.replay_csv import read_csv  # the same
    from tactile.sources.replay_npz import read_npz  # the same

    path = Path(path)
    if not path.is_file():
        raise InputError(f"no scene or recording {path}")
    if path.suffix.lower() == ".toml":
        return read_scene(path)
    readers: dict[str, Callable[[Path], Source]] = {".csv": read_csv, ".npz": read_npz, ".mcap": _read_mcap}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: suffix {path.suffix!r}, a recording in {' or '.join(readers)} wanted")
    return readers[path.suffix.lower()](path)


def _read_mcap(path: Path) -> Source:
    source: Source = need("tactile.recording.reader", "an MCAP recording").open_recording(path).source()
    return source
