"""Sources of frames: opening a scene, a recording or a ROS bag, and finding them in a folder."""

from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.extras import need
from cnnsim.support.files import named_file
from tactile.core.source import Source, provenance, report_damage

BAG = ("tactile.sources.replay_rosbag", "read_bag", "a ROS bag")
READERS = {
    ".toml": ("tactile.simulator.scene_file.file", "read_scene", "a scene"),
    ".npz": ("tactile.sources.replay_npz", "read_npz", "an NPZ file"),
    ".csv": ("tactile.sources.replay_csv", "read_csv", "a CSV file"),
    ".parquet": ("tactile.sources.replay_parquet", "read_parquet", "a Parquet file"),
    ".mcap": ("tactile.recording.reader", "read_mcap", "an MCAP recording"),
    ".bag": BAG,
    ".db3": BAG,
}
"""Suffix -> module, function and name of its reader, which is imported when used."""
EVENTS = b"# tactile_events"
"""First bytes of a table of events, which is no recording."""
KINDS = tuple(READERS)
"""Suffixes of sources; the folder of a ROS 2 bag is a source, too."""


def open_source(path: Path | str) -> Source:
    """Return the source in a file: a scene (.toml), a recording (.npz, .csv, .parquet, .mcap) or a ROS bag.

    A ROS bag is a .bag file, a .db3 file or the folder of a ROS 2 bag. A damaged recording gives a notice.

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
    module, read, what = READERS[suffix]
    source: Source = getattr(need(module, what), read)(path)
    report_damage(path, provenance(source).damage)
    return source


def is_bag(folder: Path) -> bool:
    """Return whether a folder is a ROS 2 bag."""
    return (folder / "metadata.yaml").is_file()


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
