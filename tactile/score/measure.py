"""Score of labelled recordings: agreement of events with labels, and code changes during holds."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from tactile import pipeline
from tactile.core.source import Source
from tactile.events.event import Event, EventLog
from tactile.layout.layout import Layout
from tactile.pipeline import FrameReport
from tactile.score.baselines import baseline
from tactile.score.labels import Labelled, LabelledSource
from tactile.score.match import WINDOW, Tally
from tactile.settings import Settings
from tactile.sources import KINDS, open_source, recordings_in

MARK = "baseline: "


class Watched:
    """A sink that collects events, the times of code changes, and the names of the fingers with a tare."""

    def __init__(self) -> None:
        self._log = EventLog()
        self.changes: dict[str, list[float]] = {}
        self.tared: set[str] = set()
        self._codes: dict[str, str] = {}

    @property
    def events(self) -> list[Event]:
        """All events so far."""
        return self._log.events

    def __call__(self, report: FrameReport) -> None:
        """Process one report."""
        name, code = report.array.name, report.code.ternary()
        self._log.add(report.events, report.ended)
        if code != self._codes.setdefault(name, code):
            self.changes.setdefault(name, []).append(report.frame.t)
            self._codes[name] = code
        if report.tare is not None:
            self.tared.add(name)


@dataclass
class Score:
    """Combined score of many recordings; names of the baseline begin with "baseline: ".

    ``missing``: labelled recordings that are not there; ``untared``: labelled fingers that were never tared, so that
    they have no events.
    """

    kinds: dict[str, Tally] = field(default_factory=dict)
    before_flag: list[bool] = field(default_factory=list)
    held_s: dict[int, float] = field(default_factory=dict)
    changes: dict[int, int] = field(default_factory=dict)
    held_events: int = 0
    events: list[int] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    untared: list[str] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """Return all as plain data."""
        minutes = sum(self.held_s.values()) / 60
        per_second = {str(n): round(self.changes.get(n, 0) / s, 4) for n, s in sorted(self.held_s.items()) if s}
        return {
            "kinds": {name: tally.plain() for name, tally in sorted(self.kinds.items())},
            "contact_before_flag": round(float(np.mean(self.before_flag)), 4) if self.before_flag else None,
            "code_changes_a_second_of_hold": per_second,
            "events_a_minute_of_hold": round(self.held_events / minutes, 3) if minutes else None,
            "events_a_recording": {"median": float(np.median(self.events)), "most": max(self.events)},
            "recordings_missing": self.missing,
            "fingers_untared": self.untared,
        }


def labelled_sources(
    folder: Path, labels: Iterable[Labelled], layout: Layout | None = None,
    watch: Callable[[list[str]], Iterable[str]] = iter,
) -> tuple[list[str], Iterator[LabelledSource]]:  # fmt: skip
    """Return the names of the labelled recordings that are not in the folder, and the others, opened one by one.

    Arguments: ``layout`` of tables of another program; ``watch`` passes the names on and may show progress.

    Raises:
        InputError: none of the recordings is there, or a labelled finger is missing.
    """
    by_name = dict[str, list[Labelled]]()
    for label in labels:
        by_name.setdefault(label.recording, []).append(label)
    paths = {path.name if path.is_dir() else path.stem: path for path in recordings_in(folder, layout)}
    there = [name for name in by_name if name in paths]
    missing = [name for name in by_name if name not in paths]
    if not there:
        raise InputError(f"{folder}: no recording of the labels {', '.join(missing)}; {', '.join(KINDS)} wanted")

    def opened() -> Iterator[LabelledSource]:
        for name in watch(there):
            source = open_source(paths[name], layout)
            for label in by_name[name]:
                if label.finger >= len(source.arrays):
                    raise InputError(f"{name}: {len(source.arrays)} fingers; the labels have finger {label.finger}")
            yield LabelledSource(name, source, by_name[name])

    return missing, opened()


def score(
    of: Iterable[LabelledSource], settings: Callable[[Source], Settings], window: float = WINDOW,
    missing: Iterable[str] = (),
) -> Score:  # fmt: skip
    """Run every labelled recording through the pipeline and count; ``window`` [s] of a match.

    If the labels of a recording name a kind for one finger, that kind is judged on all its labelled fingers.
    """
    total = Score(missing=list(missing))
    for case in of:
        seen, chosen = Watched(), settings(case.source).of(case.source)
        pipeline.run(case.source, chosen, [seen])
        total.events.append(len(seen.events))
        for label in case.labels:
            name = case.source.arrays[label.finger].name
            if chosen.tare != "off" and name not in seen.tared:
                total.untared.append(f"{case.name}: {name}")
            _judge(total, seen, label, case.source, window)
    return total


def _judge(total: Score, seen: Watched, label: Labelled, source: Source, window: float) -> None:
    array = source.arrays[label.finger]
    mine = [(event.t, event.kind) for event in seen.events if event.finger == array.name]
    raw = [(one.t, np.where(one.valid[..., None], one.values, np.nan)) for one in source if one.finger == label.finger]
    times, values = zip(*raw, strict=True)
    plain = baseline(np.array(times), np.array(values), 1.0 if array.quantity == "force" else -1.0)
    for kind, known in label.times.items():
        for prefix, found in (("", mine), (MARK, plain)):
            # only the first tangential load is labelled
            onsets = [t for t, what in found if what == kind]
            total.kinds.setdefault(prefix + kind, Tally()).add(onsets, [known], window)
    if label.flag is not None:
        contacts = [t for t, what in mine if what == "contact"]
        total.before_flag.append(bool(contacts) and min(contacts) < label.flag)
    if label.holds is not None:
        start, stop = label.holds
        changed = [t for t in seen.changes.get(array.name, []) if start <= t <= stop]
        total.held_s[label.finger] = total.held_s.get(label.finger, 0.0) + stop - start
        total.changes[label.finger] = total.changes.get(label.finger, 0) + len(changed)
        total.held_events += sum(start <= t <= stop for t, _ in mine)
