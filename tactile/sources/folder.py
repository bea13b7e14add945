"""Recordings and scenes in a folder, found by their suffixes."""

from pathlib import Path

from cnnsim.support import InputError
from tactile.sources import KINDS, is_bag

EVENTS = b"# tactile_events"
"""First bytes of a table of events, which is no recording."""


def is_folder_of_recordings(source: Path) -> bool:
    """Return whether a source is a folder of recordings, and not a bag."""
    return source.is_dir() and not is_bag(source)


def recordings_in(folder: Path) -> list[Path]:
    """Return the sources in a folder, sorted by name: files of `KINDS` and folders that are bags.

    A CSV file without the header of a recording, such as a table of labels, is skipped.

    Raises:
        InputError: no such folder.
    """
    if not folder.is_dir():
        raise InputError(f"no folder {folder}")
    return [one for one in sorted(folder.iterdir()) if is_bag(one) or (one.is_file() and _is_recording(one))]


def _is_recording(path: Path) -> bool:
    suffix = path.suffix.lower()
    if suffix != ".csv":
        return suffix in KINDS
    try:
        with path.open("rb") as file:
            start = file.read(len(EVENTS))
            return start[:1] == b"#" and start != EVENTS
    except OSError:
        return True  # its reader reports the fault
