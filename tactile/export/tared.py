"""Exports of recordings after the tare of a run: frames, messages for viewers, ROS 2 bags."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from cnnsim.support import InputError
from cnnsim.support.limits import reason
from tactile import pipeline
from tactile.core.frame import Frame
from tactile.core.source import FrameStream, provenance, with_frames
from tactile.opened import Opened, RunChoices, open_for_run
from tactile.settings import PipelineOptions

if TYPE_CHECKING:
    from tactile.export.drawable import Message
    from tactile.layout.layout import Layout


def open_for_export(path: Path, layout: "Layout | Path | None" = None) -> Opened:
    """Open a scene, a recording or a table with a ``layout``, with the settings of `tactile run`.

    Raises:
        InputError: it cannot be opened, or its readings have no unit.
    """
    return open_for_run(path, RunChoices(PipelineOptions(), layout=layout))


def tared(path: Path, layout: Path | None = None) -> FrameStream:
    """Return the frames of a scene or recording after tare and gains, as the pipeline processes them.

    Taxels are not valid until the first tare. The header keeps the Unix time of t = 0, and says that no tare is needed.

    Raises:
        InputError: as `open_for_export`.
    """
    opened = open_for_export(path, layout)
    source = opened.source
    known = replace(provenance(source), untared=False, uncalibrated=(), choices="")
    return FrameStream(source.title, source.arrays, source.modulus, source.frames, _Tared(opened), known)


class _Tared:
    """The frames after the tare; iterable repeatedly."""

    def __init__(self, opened: Opened) -> None:
        self._opened = opened

    def __iter__(self) -> Iterator[Frame]:
        return (report.frame for report in pipeline.reports(self._opened.source, self._opened.settings))


def drawn(opened: Opened, frames: Iterable[Frame], start_ns: int, *, ros: bool = False) -> "Iterator[Message]":
    """Return the messages that viewers draw of the ``frames`` of an opened recording; arguments as `Drawable`."""
    from tactile.export.drawable import Drawable  # rosbags is slow to import

    drawable = Drawable(opened.source.arrays, start_ns, ros=ros)
    for report in pipeline.reports(with_frames(opened.source, frames), opened.settings):
        yield from drawable(report)


def write_ros2(folder: Path, messages: "Iterable[Message]") -> int:
    """Write a ROS 2 bag (SQLite), for `ros2 bag play` and RViz; return the number of messages.

    Its metadata has version 8, which Humble and later releases read.

    Raises:
        InputError: no messages; the name is taken, or the folder cannot be written.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer  # rosbags is slow to import

    from tactile.export.drawable import typestore  # the same

    with new_folder(folder) as made:
        made.rmdir()  # the library makes it
        topics, count = {}, 0
        with Writer(made, version=8, storage_plugin=StoragePlugin.SQLITE3) as bag:
            for message in messages:
                if message.topic not in topics:
                    topics[message.topic] = bag.add_connection(message.topic, message.schema, typestore=typestore())
                bag.write(topics[message.topic], message.ns, message.data)
                count += 1
        if not count:
            raise InputError(f"{folder}: no frames to write, at least one wanted")
    return count


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder; it gets the name ``path`` when the block succeeds, and is removed when it fails.

    Raises:
        InputError: the name is taken, or the folder cannot be written.
    """
    if path.exists() or path.is_symlink():
        raise InputError(f"{path}: there is something of that name; another name wanted")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=f".{path.name[:40]}-", dir=path.parent) as place:
            folder = Path(place) / path.name
            folder.mkdir()
            yield folder
            folder.rename(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {reason(error)}") from error
