"""Conversion of recordings and scenes to CSV, NPZ, Parquet and MCAP, with a report of what a format cannot hold."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.exclusive_file import refuse_existing
from cnnsim.support.extras import need
from cnnsim.support.files import writing
from tactile.core.frame import Frame
from tactile.core.source import Source, with_frames
from tactile.sources import open_source
from tactile.sources.replay_csv import write_csv
from tactile.sources.replay_npz import write_npz
from tactile.sources.replay_pillars import PILLAR_PITCH, PillarStream

if TYPE_CHECKING:
    from tactile.recording.index import Others


class Conversion(NamedTuple):
    """Number of frames written, and notes on what was assumed or omitted."""

    frames: int
    notes: tuple[str, ...]


def convert(
    source: Path,
    target: Path,
    replace: bool = False,
    watch: Callable[[Iterable[Frame], int | None], Iterable[Frame]] = lambda seen, _: seen,
    opened: Source | None = None,
    others: "Others | None" = None,
) -> Conversion:
    """Write the frames of ``source`` to ``target`` in the format of its suffix.

    Arrays, names, units, times, sequence numbers and flags are kept bit for bit. The target is written completely or
    not at all. ``watch`` receives the frames and their number, and passes them on. ``opened``: the frames to write,
    unless they are those of the file; ``others``: makes further messages of an MCAP file.

    Raises:
        InputError: an unknown suffix, an existing target (unless ``replace``), no frames, a full disk, or errors of the
            reader or writer.
    """
    suffix = target.suffix.lower()
    if suffix == ".toml":
        raise InputError(f"{target}: frames make no scene; a recording, one of {', '.join(WRITERS)} wanted")
    if suffix not in WRITERS:
        raise InputError(f"{target}: suffix {target.suffix!r}, one of {', '.join(WRITERS)} wanted")
    if others is not None and suffix != ".mcap":
        raise InputError(f"{target}: messages that viewers draw fit into no {suffix} file; .mcap wanted")
    if target.exists() and target.samefile(source):
        raise InputError(f"{target} is the recording itself; another name wanted")
    copied = opened is None and suffix == source.suffix.lower() == ".mcap"
    opened, seen = opened or open_source(source), _Seen()
    refuse_existing(target, replace)
    with writing(target, replace=True) as beside:
        frames = seen.through(watch(opened, opened.frames))
        if copied:
            need("tactile.recording.index", "an MCAP recording").write_indexed(source, beside, others, frames)
            for _ in frames:
                pass
        elif others is not None:
            _mcap(beside, with_frames(opened, frames), others)
        else:
            WRITERS[suffix](beside, with_frames(opened, frames))
        if not seen.frames:
            raise InputError(f"{source}: no frames in it, at least one wanted; {target} is not written")
    notes = [*getattr(opened, "notes", ()), *_assumed(source, opened)]
    if not copied:
        notes += _left_behind(source, opened)
    if suffix == ".csv" and seen.masked:
        notes.append(f"readings of {seen.masked} taxels that are not valid are empty cells in {target}")
    if suffix == ".csv" and seen.unread:
        notes.append(f"{seen.unread} taxels without a finite reading, though said to be valid, are not in {target}")
    return Conversion(seen.frames, tuple(notes))


class _Seen:
    """Counts frames, and taxels whose flag and reading contradict each other."""

    frames = masked = unread = 0

    def through(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        for frame in frames:
            self.frames += 1
            finite = np.isfinite(frame.values)
            self.masked += int((~frame.valid & finite.any(-1)).sum())
            self.unread += int((frame.valid & ~finite.all(-1)).sum())
            yield frame


def _assumed(path: Path, source: Source) -> list[str]:
    """Return a note on facts that the file does not have and its reader assumes."""
    if isinstance(source, PillarStream):
        return [f"{path} says neither pitch nor names: {PILLAR_PITCH * 1e3:g} mm, nominal, and names are supposed"]
    return []


def _left_behind(path: Path, source: Source) -> list[str]:
    """Return a note on contents of the source that are not frames."""
    left = list(source.others) if isinstance(source, PillarStream) else []
    if path.suffix.lower() == ".toml":
        left.append("the loads that it knows to be true")
        if getattr(source, "bumps", None) is not None:
            left.append("the cover's bumps (forces are located as on a flat cover)")
    if path.suffix.lower() == ".mcap":
        messages = need("tactile.recording.reader", "an MCAP recording").open_recording(path).messages
        left += [
            f"{count} messages of {topic}" for topic, count in messages.items() if not topic.startswith("/frames/")
        ]
    return [f"stays in {path}: {', '.join(left)}"] if left else []


def _parquet(path: Path, source: Source) -> None:
    need("tactile.sources.replay_parquet", "a Parquet file").write_parquet(path, source)


def _mcap(path: Path, source: Source, others: "Others | None" = None) -> None:
    need("tactile.recording.index", "an MCAP recording").write_frames(path, source, others)


WRITERS: dict[str, Callable[[Path, Source], Any]] = {
    ".csv": write_csv, ".npz": write_npz, ".parquet": _parquet, ".mcap": _mcap,
}  # fmt: skip
