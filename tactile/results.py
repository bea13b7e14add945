"""Result of a run: a table of events, and frames, loads, codes and program outputs as arrays; its figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats
from cnnsim.support.command_line import watched
from cnnsim.support.errors import InputError, shown
from cnnsim.support.extras import need
from cnnsim.support.keywords import spelled
from tactile import pipeline
from tactile.core.frame import TaxelArray
from tactile.core.source import Source, with_frames
from tactile.events.event import Event
from tactile.opened import RunChoices, for_run
from tactile.output.collected import Collected, Columns, ProgramOutput
from tactile.output.event_table import COLUMNS, event_row
from tactile.output.invalid_readings import InvalidReadings
from tactile.pipeline import FrameReport
from tactile.settings import PipelineOptions, Settings
from tactile.sources import open_source

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Codes = NDArray[np.int8]
"""An array of ternary codes."""
MOST_ROWS = 40
"""Number of events that a notebook shows."""
HEAD = ("onset [s]", "end [s]", "finger", "event", "code")


class EventTable(Sequence[Event]):
    """The events of a run, sorted by onset: a sequence of `Event`, which is printed as a table."""

    def __init__(self, events: Sequence[Event]) -> None:
        self._events = tuple(events)

    def __len__(self) -> int:
        return len(self._events)

    @overload
    def __getitem__(self, at: int) -> Event: ...
    @overload
    def __getitem__(self, at: slice) -> EventTable: ...
    def __getitem__(self, at: int | slice) -> Event | EventTable:
        return EventTable(self._events[at]) if isinstance(at, slice) else self._events[at]

    def __iter__(self) -> Iterator[Event]:
        return iter(self._events)

    def to_pandas(self) -> Any:
        """Return a pandas data frame with a row for each event and the columns of events.csv, in SI units.

        Raises:
            InputError: pandas is not installed.
        """
        pandas = need("pandas", "a data frame", None)
        names = [
            name for name in COLUMNS if name not in ("recording", "unit", "error") and name[-3:] not in ("off", "_on")
        ]
        rows = [event_row("", event, None, None) | {"data": dict(event.data)} for event in self]
        return pandas.DataFrame(rows, columns=names)

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (
                f"{e.t:.3f}",
                "" if e.end is None else f"{e.end:.3f}",
                e.finger,
                e.words,
                e.arrows if len(e.taxels) <= 16 else "",
            )
            for e in self
        ]

    def __repr__(self) -> str:
        rows = self._rows()
        widths = [max(map(len, column)) for column in zip(*rows, HEAD, strict=True)]
        lines = ("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) for row in [HEAD, *rows])
        return "\n".join(line.rstrip() for line in lines) if rows else "no events"

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading, table

        more = len(self) - MOST_ROWS
        rest = heading("", f"and {more} more; to_pandas() has all") if more > 0 else ""
        return (table(self[:MOST_ROWS]._rows(), HEAD) if self else heading("no events")) + rest


@dataclass(frozen=True, eq=False, repr=False)
class TouchResult:
    """The result of a run. Its dictionaries have an entry for each finger, with one row for each of its frames.

    ``arrays``: arrays of the fingers; ``events``: a table of all events; ``times`` (frames,) [s]; ``frames`` (frames,
    rows, cols, 3): shear_x, shear_y and normal after the tare, in the unit of the quantity, NaN for invalid taxels;
    ``loads``: x, y [m], Q, R, F [N] and further columns, each (frames,); ``codes`` (frames, rows, cols, 2): directions
    of shear along x and y, -1, 0 or 1; ``programs``: outputs of the user's programs where they changed, as (t, finger,
    program, planes by name); ``settings`` of the run; ``notes``: sentences about the source and its invalid readings.
    """

    title: str
    arrays: tuple[TaxelArray, ...]
    settings: Settings
    events: EventTable
    times: dict[str, Floats]
    frames: dict[str, Floats]
    loads: dict[str, Columns]
    codes: dict[str, Codes]
    programs: list[ProgramOutput]
    notes: tuple[str, ...]
    _collected: Collected = field(repr=False)

    def plot(self) -> list[Axes]:
        """Draw events, signals and the taxel plane of each finger into a new figure of pyplot; return its axes."""
        from matplotlib import pyplot  # slow to import

        from tactile.output.plot import draw_run

        figure = pyplot.figure()
        draw_run(figure, self._collected, self.arrays, self.title)
        return figure.axes

    def __repr__(self) -> str:
        sizes = ", ".join(f"{one.name} {one.rows} x {one.cols}: {len(self.times[one.name])}" for one in self.arrays)
        return f"TouchResult({self.title!r}, {len(self.events)} events, frames of {sizes})"

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading

        return heading("Touch", repr(self)[len("TouchResult(") : -1]) + self.events._repr_html_()


class _Planes:
    """A sink that keeps the planes of all frames by finger."""

    def __init__(self, arrays: tuple[TaxelArray, ...]) -> None:
        self._frames: dict[str, list[Floats]] = {array.name: [] for array in arrays}
        self._codes: dict[str, list[Codes]] = {array.name: [] for array in arrays}
        self._shapes = {array.name: array.shape for array in arrays}

    def __call__(self, report: FrameReport) -> None:
        name, frame = report.array.name, report.frame
        self._frames[name].append(np.where(frame.valid[..., None], frame.values, np.nan))
        self._codes[name].append(np.stack([report.code.x, report.code.y], -1))

    def frames(self, name: str) -> Floats:
        """Return the values (frames, rows, cols, 3) of a finger."""
        return np.array(self._frames[name]).reshape(-1, *self._shapes[name], 3)

    def codes(self, name: str) -> Codes:
        """Return the codes (frames, rows, cols, 2) of a finger."""
        return np.array(self._codes[name], np.int8).reshape(-1, *self._shapes[name], 2)


@spelled()
def run(
    source: Source | str | Path, settings: Settings | None = None, *, layout: str | Path | None = None
) -> TouchResult:
    """Run the pipeline on a scene, a recording or any source of frames, and return all that it finds.

    result = tactile.run("grip.toml")
    result.events  # a table

    Arguments: ``source``, a file, a folder that is one recording, or a source of frames; ``settings``, None for those
    of `tactile run`; ``layout`` of a table of another program. Frames are kept in memory; `tactile.stream` yields them
    one at a time.

    Raises:
        InputError: the source cannot be opened or read, or settings that do not fit it.
    """
    if not isinstance(settings, Settings | None):
        raise InputError(f"settings {shown(settings)}; Settings(...) wanted")
    if not isinstance(source, str | Path) and not hasattr(source, "arrays"):
        raise InputError(f"source {shown(source)}; a file or a source of frames wanted")
    name = str(source) if isinstance(source, str | Path) else source.title
    if isinstance(source, str | Path):
        source = open_source(source, layout)
    opened = for_run(source, RunChoices(PipelineOptions()), name)
    settings = settings or opened.settings
    unread, collected, planes = InvalidReadings(source.arrays), Collected(), _Planes(source.arrays)
    passed = with_frames(source, watched(unread.through(source), "touch", source.frames))
    pipeline.run(passed, settings, [collected, planes])
    names = [array.name for array in source.arrays]
    loads = {name: collected.columns(name) for name in names}
    return TouchResult(
        source.title,
        source.arrays,
        settings.of(source),
        EventTable(collected.events),
        {name: one.t for name, one in loads.items()},
        {name: planes.frames(name) for name in names},
        loads,
        {name: planes.codes(name) for name in names},
        collected.outputs,
        tuple(filter(None, (*opened.notes, opened.forces, *unread.lines))),
        collected,
    )
