"""Streams of frames for control loops: a port or a file in, tared frames with events out, as they come."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.extras import need
from cnnsim.support.toml_file import read_toml
from cnnsim.support.values import is_number
from tactile import pipeline
from tactile.core.frame import TaxelArray
from tactile.core.source import provenance
from tactile.output.stream_frame import FRICTION, StreamFrame, StreamFrames
from tactile.pipeline import FrameReport
from tactile.settings import PipelineOptions, Settings
from tactile.sources import is_file_source

if TYPE_CHECKING:
    from tactile.serial.session import Session
    from tactile.wire.description import Description


class Stream:
    """The frames of a port or a file, one at a time, in a ``for`` or an ``async for`` loop.

    ``arrays``: arrays of the fingers. It ends with the file, or when it is closed; a port is closed at the end of the
    ``with`` block.
    """

    def __init__(
        self, reports: Iterator[FrameReport], arrays: tuple[TaxelArray, ...], convert: StreamFrames,
        session: Session | None = None,
    ) -> None:  # fmt: skip
        self.arrays = arrays
        self._session, self._closed = session, False
        self._frames = map(convert, reports)

    def __repr__(self) -> str:
        return f"Stream({', '.join(f'{array.name} {array.rows} x {array.cols}' for array in self.arrays)})"

    def __iter__(self) -> Iterator[StreamFrame]:
        return self

    def __next__(self) -> StreamFrame:
        return next(self._frames)

    async def __aiter__(self) -> AsyncIterator[StreamFrame]:
        """Yield the frames; while one is awaited, a thread waits for it and the event loop runs."""
        while (frame := await asyncio.to_thread(next, self._frames, None)) is not None:
            yield frame

    def tare(self, *, force: bool = False) -> None:
        """Request a tare of a port; it is refused while the array is loaded, unless ``force``."""
        if self._session is not None:
            self._session.reader.ask_tare(force)

    def close(self) -> None:
        """Close the port; the frames that have arrived still come."""
        if self._session is not None and not self._closed:
            self._closed = True
            self._session.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def stream(
    port_or_file: str | Path, array: str | Path | Description | None = None, settings: Settings | None = None,
    *, friction: float = FRICTION, seconds: float | None = None,
) -> Stream:  # fmt: skip
    """Return the frames of a serial port, or of a scene or recording, as a control loop wants them.

    with tactile.stream("/dev/ttyACM0", "hand.toml") as frames:
        for frame in frames:
            grip.hold(frame.load.F, frame.slip_margin)

    Arguments: ``array``: array description of a port, its file or the name of a protocol with one form; a recording has
    its own, which must have the same arrays, and a table of another program needs one with a layout; ``settings``:
    those of `tactile live` or `tactile run` unless given; ``friction``: coefficient of friction of the slip margin
    until a slip has been measured; ``seconds`` [s] after which a port is closed.

    Raises:
        InputError: the port or file cannot be opened, no array of a port, arrays that differ from those of the file.
    """
    if not isinstance(port_or_file, str | Path):
        raise InputError(f"stream({shown(port_or_file)}, ...); the name of a port or a file wanted")
    if not is_number(friction) or not friction > 0:
        raise InputError(f"friction {shown(friction)}; a positive number wanted")
    path = Path(port_or_file)
    if is_file_source(path):
        return _of_file(path, array, settings, friction)
    description = None if array is None else _described(array)
    if description is None:
        raise InputError(f"stream({str(port_or_file)!r}): a port, and no array; the file that describes it wanted")
    description.check_calibrated()
    session_of = need("tactile.serial.session", "a serial port").Session
    wire = need("tactile.wire.source", "a serial port").WireSource
    if settings is None:
        settings = replace(PipelineOptions(), tare="auto").settings(wire(description, ()))
    pipeline.warm_up(description.arrays, description.modulus, settings)
    fingers = pipeline.make_fingers(description.arrays, description.modulus, settings)  # before the first frame
    session: Session = session_of(str(port_or_file), description, None, seconds)
    reports = pipeline.reports(session.source, settings, fingers)
    return Stream(reports, description.arrays, StreamFrames(session.reader.epoch.unix, friction), session)


def _of_file(
    path: Path, array: str | Path | Description | None, settings: Settings | None, friction: float
) -> Stream:  # fmt: skip
    from tactile.opened import RunChoices, open_for_run  # slow to import

    layout = Path(array) if isinstance(array, str | Path) and _has_layout(Path(array)) else None
    wanted = None if array is None or layout is not None else _described(array)
    opened = open_for_run(path, RunChoices(PipelineOptions(), layout=layout))
    source = opened.source
    if wanted is not None and [one.shape for one in wanted.arrays] != [one.shape for one in source.arrays]:
        found, said = (", ".join(f"{a.name} {a.rows} x {a.cols}" for a in one.arrays) for one in (source, wanted))
        raise InputError(f"{path} has arrays {found}; the array description has {said}")
    reports = pipeline.reports(source, settings or opened.settings)
    return Stream(reports, source.arrays, StreamFrames(provenance(source).start_ns, friction))


def _has_layout(array: Path) -> bool:
    """Return whether an array file describes tables of other programs."""
    return array.is_file() and "layout" in read_toml(array, "array description")


def _described(array: str | Path | Description) -> Description:
    from tactile.wire.description import Description  # NumPy is slow to import
    from tactile.wire.description_file import default_description, read_description  # the same
    from tactile.wire.registry import NAMES  # the same

    if isinstance(array, Description):
        return array
    if not isinstance(array, str | Path):
        raise InputError(f"array {shown(array)}; the file that describes it wanted")
    return default_description(str(array)) if str(array) in NAMES else read_description(Path(array))
