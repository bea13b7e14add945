"""Opening a source of frames: a scene or a recording."""

from pathlib import Path

from cnnsim.support import InputError
from tactile.core.source import Source


def open_source(path: Path | str) -> Source:
    """Return the source that a file is: a scene (.toml) or a recording (.npz, .csv, .mcap).

    Raises:
        InputError: the file is missing, of no known kind, or wrong inside.
    """
    from tactile.simulator.scene.file import read_scene  # only what the file needs is imported
    from tactile.sources.replay import read_recording  # the same

    path = Path(path)
    if not path.is_file():
        raise InputError(f"no scene or recording {path}")
    return read_scene(path) if path.suffix.lower() == ".toml" else read_recording(path)
