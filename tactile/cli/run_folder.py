"""Runs many recordings through the pipeline into one table of events."""

from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import cnnsim
from cnnsim.support import InputError
from cnnsim.support.command_line import print_json, watched
from cnnsim.support.extras import need
from cnnsim.support.terminal import echo, say, say_table
from tactile import pipeline
from tactile.core.source import provenance, with_frames
from tactile.events.event import Event, EventLog
from tactile.opened import Opened, RunChoices, open_for_run
from tactile.output.event_table import TOLD, UNITS, event_row, write_events
from tactile.output.invalid_readings import InvalidReadings
from tactile.output.json_data import settings_data
from tactile.pipeline import FrameReport
from tactile.sources import layout_of, passed_over, recordings_in
from tactile.thresholds.levels import Levels

MOST_PASSED = 20
"""Largest number of files passed over that are listed."""


@dataclass
class _Watch:
    """A sink that collects the events, the levels of each, and the duration."""

    log: EventLog = field(default_factory=EventLog)
    levels: dict[tuple[str, str, float], Levels | None] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)
    frames: int = 0
    first: float = float("inf")
    last: float = float("-inf")

    def __call__(self, report: FrameReport) -> None:
        self.frames += 1
        self.notices += [f"{report.array.name}: {one.why}: {one.detail}" for one in report.tares if one.notice]
        self.first, self.last = min(self.first, report.frame.t), max(self.last, report.frame.t)
        if report.events or report.ended:
            self.log.add(report.events, report.ended)
            for event in report.events:
                self.levels[event.key] = report.levels if event.finger == report.array.name else None

    def rows(self, name: str, opened: Opened) -> list[dict[str, Any]]:
        quantity = {array.name: array.quantity for array in opened.source.arrays}

        def row(event: Event) -> dict[str, Any]:
            return event_row(name, event, self.levels.get(event.key), quantity.get(event.finger))

        return [row(event) for event in self.log.events]


def run_folder(folder: Path, choices: RunChoices, output: Path | None, *, parquet: bool, as_json: bool) -> None:
    """Run the recordings and scenes of a folder; an unreadable one becomes a row with its error.

    Raises:
        InputError: none in it, none that can be run, or a table that cannot be written.
    """
    layout = layout_of(folder, choices.layout)
    files, passed = recordings_in(folder, layout), passed_over(folder, layout)
    left = [f"{name}: passed over, {why}" for name, why in passed.items()]
    if not files:
        raise InputError(f"{folder}: no recordings or scenes in it, which are wanted{'; '.join(['', *left])}")
    choices = replace(choices, layout=layout)
    if parquet:
        need("tactile.recording.parquet_rows", "a Parquet table")  # fails before the work
    rows: list[dict[str, Any]] = []
    recordings = []
    for file in watched(files, "recordings", len(files)):
        try:
            found, told = _run(file, choices)
        except (InputError, OSError, MemoryError) as error:
            said = " ".join(str(error).split()) or type(error).__name__
            found, told = [{"recording": file.name, "error": said}], {"recording": file.name, "error": said}
        rows += found
        recordings.append(told)
    broken = [one for one in recordings if "error" in one]
    if len(broken) == len(recordings):
        raise InputError(f"{folder}: none of {len(files)} could be run; first {broken[0]['error']}")
    options = {name: one for name, one in asdict(choices.options).items() if name != "tare"}
    head = {
        "version": cnnsim.__version__, "folder": folder.name, "options": options,
        "tare": choices.tare, "gains": None if choices.gains is None else asdict(choices.gains),
        "calibration": None if choices.calibration is None else choices.calibration.name,
        "columns": TOLD, "units": dict(UNITS), "recordings": recordings, "passed_over": passed,
    }  # fmt: skip
    if output is not None:
        write_events(output, rows, head, parquet=parquet)
    if as_json:
        print_json({**head, "events": rows})
    else:
        _print(recordings)
        for line in left[:MOST_PASSED]:
            say(line, err=True)
    if output is not None:
        also = f", {output / 'events.parquet'}" if parquet else ""
        echo(f"wrote {output / 'events.csv'}{also}", err=as_json)


def _run(file: Path, choices: RunChoices) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Return the event rows of one recording, and a summary of it."""
    opened, seen = open_for_run(file, choices), _Watch()
    source, unread = opened.source, InvalidReadings(opened.source.arrays)
    pipeline.run(with_frames(source, unread.through(source)), opened.settings, [seen])
    rows = seen.rows(file.name, opened)
    return rows, {
        "recording": file.name, "title": opened.source.title, "frames": seen.frames,
        "seconds": max(seen.last - seen.first, 0.0),
        "fingers": {array.name: UNITS[array.quantity] for array in opened.source.arrays},
        **settings_data(opened.settings),
        "events": dict(Counter(row["kind"] for row in rows)),
        "notes": [*opened.notes, *seen.notices, *filter(None, [provenance(source).damage, opened.forces])],
        "unread": unread.lines,
    }  # fmt: skip


def _print(recordings: list[dict[str, Any]]) -> None:
    lines: list[tuple[str, str]] = []
    for one in recordings:
        if "error" in one:
            lines.append((one["recording"], f"error: {one['error']}"))
            continue
        events = ", ".join(f"{count} {kind}" for kind, count in one["events"].items()) or "no events"
        lines.append((one["recording"], f"{one['frames']} frames in {one['seconds']:.1f} s: {events}"))
        lines += [("", line) for line in (*one["notes"], *one["unread"])]
    say_table(lines, 40)
    broken = sum("error" in one for one in recordings)
    total = sum(sum(one.get("events", {}).values()) for one in recordings)
    echo(f"{len(recordings)} recordings, {total} events" + (f"; {broken} could not be run" if broken else ""))
