"""Sources of frames: opening a scene, a recording, a ROS bag or a foreign table, and finding them in a folder."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from cnnsim.support import InputError
from cnnsim.support.extras import need
from cnnsim.support.files import named_file
from tactile.core.source import ForeignFileError, Source, provenance, report_damage

if TYPE_CHECKING:
    from tactile.layout.layout import Layout

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
FOREIGN = (".tsv", ".txt", ".dat", ".log", ".npy", ".mat", ".h5", ".hdf5")
"""Suffixes of tables of other programs alone, which need a layout."""
EVENTS = b"# tactile_events"
"""First bytes of a table of events, which is no recording."""
KINDS = tuple(READERS)
"""Suffixes of sources; the folder of a ROS 2 bag is a source, too."""
LAYOUT = "layout.toml"
"""File name of the layout of the foreign tables of a folder."""


def open_source(path: Path | str, layout: "Layout | Path | str | None" = None) -> Source:
    """Return the source in a file: a scene (.toml), a recording (.npz, .csv, .parquet, .mcap) or a ROS bag.

    A ROS bag is a .bag file, a .db3 file or the folder of a ROS 2 bag. A damaged recording gives a notice. A table of
    another program is read by its ``layout``, an array file with a table [layout] (docs/bring-your-own-recording.md);
    without one, by the file ``layout.toml`` in its folder.

    Raises:
        InputError: no path; a missing file, an unknown suffix, or invalid contents.
    """
    path = named_file(path)
    suffix = ".bag" if path.is_dir() else path.suffix.lower()
    if not path.exists():
        raise InputError(f"no scene or recording {path}")
    if path.is_dir() and not is_bag(path):
        raise InputError(f"{path}: a folder, and no ROS bag (no metadata.yaml in it); a scene or recording wanted")
    if suffix not in (*KINDS, *FOREIGN):
        raise InputError(f"{path}: suffix {path.suffix!r}, a scene or recording in {', '.join(KINDS)} wanted")
    chosen = None if suffix == ".toml" else layout_of(path, layout)
    try:
        if suffix not in KINDS or (chosen is not None and chosen.topic):
            raise ForeignFileError(f"{path}: no recording of this program")
        module, read, what = READERS[suffix]
        source: Source = getattr(need(module, what), read)(path)
    except InputError as error:
        of_another = isinstance(error, ForeignFileError)
        if not of_another and (chosen is None or not isinstance(error.__cause__, UnicodeDecodeError)):
            raise
        if suffix == ".mcap" and (chosen is None or not chosen.topic):
            with suppress(InputError):  # a ROS 2 bag without its folder
                found: Source = need(BAG[0], BAG[2]).read_bag(path)
                return found
        if chosen is None:
            raise ForeignFileError(_way_in(path)) from error
        from tactile.layout.source import read_foreign  # imported when used

        return read_foreign(path, chosen)
    report_damage(path, provenance(source).damage)
    return source


def layout_of(path: Path, layout: "Layout | Path | str | None" = None) -> "Layout | None":
    """Return a layout: the given one, that of a file, or of the file ``layout.toml`` in or next to ``path``.

    Raises:
        InputError: the file is wrong.
    """
    beside = (path if path.is_dir() and not is_bag(path) else path.parent) / LAYOUT
    if layout is None and not beside.is_file():
        return None
    from tactile.layout.layout import Layout, read_layout  # imported when used

    return layout if isinstance(layout, Layout) else read_layout(Path(layout or beside))


def _way_in(path: Path) -> str:
    """Return the message on a file of another program: what is in it, and how it is read."""
    from tactile.layout.table import read_table  # imported when used

    try:
        inside = f"it has {read_table(path).names}"
    except InputError as error:
        inside = str(error).removeprefix(f"{path}: ")
    way = f"`tactile layout {path.name} -o {LAYOUT}` writes a layout, with which it is read"
    return f"{path}: no recording of this program, but a table of another one: {inside}; {way} (--layout {LAYOUT})"


def is_file_source(path: Path) -> bool:
    """Return whether a path names a scene or a recording, and not a port; it may be missing."""
    return path.is_file() or path.is_dir() or path.suffix.lower() in (*KINDS, *FOREIGN)


def is_bag(folder: Path) -> bool:
    """Return whether a folder is a ROS 2 bag."""
    return (folder / "metadata.yaml").is_file()


def is_folder_of_recordings(source: Path) -> bool:
    """Return whether a source is a folder of recordings, and not a bag."""
    return source.is_dir() and not is_bag(source)


def recordings_in(folder: Path, layout: "Layout | None" = None) -> list[Path]:
    """Return the sources in a folder, sorted by name: files of `KINDS` and folders that are bags.

    With a ``layout`` also tables of other programs; if it has ``files``, those files alone.

    Raises:
        InputError: no such folder.
    """
    if not folder.is_dir():
        raise InputError(f"no folder {folder}")
    if layout is not None and layout.files:
        return sorted(one for one in folder.glob(layout.files) if one.is_file() or is_bag(one))
    return [one for one in sorted(folder.iterdir()) if not _why_not(one, layout)]


def passed_over(folder: Path, layout: "Layout | None" = None) -> dict[str, str]:
    """Return for each file in a folder that is no source why it is passed over."""
    if layout is not None and layout.files:
        return {}
    reasons = {one.name: _why_not(one, layout) for one in sorted(folder.iterdir())}
    return {name: why for name, why in reasons.items() if why and name != LAYOUT and not name.startswith(".")}


def _why_not(path: Path, layout: "Layout | None") -> str:
    """Return why a file is no source, an empty text for a source."""
    suffix = path.suffix.lower()
    if path.is_dir():
        return "" if is_bag(path) else "a folder"
    if path.name == LAYOUT:
        return "a layout"
    if suffix in FOREIGN:
        return "" if layout is not None else "a table of another program: `tactile layout` writes a layout for it"
    if suffix not in KINDS:
        return f"suffix {suffix!r}"
    if suffix != ".csv":
        return ""
    try:
        with path.open("rb") as file:
            start = file.read(len(EVENTS))
    except OSError:
        return ""  # its reader reports the fault
    if start == EVENTS:
        return "a table of events"
    if start[:1] == b"#" or layout is not None:
        return ""
    return f"no header of a recording: a table of labels, or of another program (`tactile layout {path.name}`)"
