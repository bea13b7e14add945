"""Score of labelled recordings: agreement of events with labels, and code changes during holds."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile import pipeline
from tactile.core.source import Source
from tactile.events.event import Event, EventLog
from tactile.pipeline import FrameReport
from tactile.score.baselines import baseline
from tactile.score.labels import Labelled
from tactile.score.match import WINDOW, Tally
from tactile.settings import Settings

SUFFIXES = (".mcap", ".npz", ".csv", ".toml")
MARK = "baseline: "


def voted(x: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return a ternary plane (rows, cols) with 0 where no 8-neighbour agrees: a vote of the neighbourhood."""
    around = np.pad(x, 1)
    rows, cols = x.shape
    agree = np.zeros(x.shape, bool)
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                agree |= around[i : i + rows, j : j + cols] == x
    return np.where(agree, x, 0).astype(np.int8)


class Watched:
    """A sink that collects events, and the times of code changes, also after the neighbourhood vote."""

    def __init__(self) -> None:
        self._log = EventLog()
        self.changes: dict[str, list[float]] = {}
        self.voted_changes: dict[str, list[float]] = {}
        self._codes: dict[str, str] = {}
        self._voted: dict[str, bytes] = {}

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
            vote = voted(report.code.x).tobytes() + voted(report.code.y).tobytes()
            if vote != self._voted.get(name, vote):
                self.voted_changes.setdefault(name, []).append(report.frame.t)
            self._voted[name] = vote


@dataclass
class Score:
    """Combined score of many recordings; names of the baseline begin with "baseline: "."""

    kinds: dict[str, Tally] = field(default_factory=dict)
    before_flag: list[bool] = field(default_factory=list)
    held_s: dict[int, float] = field(default_factory=dict)
    changes: dict[int, int] = field(default_factory=dict)
    voted_changes: dict[int, int] = field(default_factory=dict)
    held_events: int = 0
    events: list[int] = field(default_factory=list)

    def plain(self) -> dict[str, Any]:
        """Return all as plain data."""
        minutes = sum(self.held_s.values()) / 60
        per_second = {str(n): round(self.changes.get(n, 0) / s, 4) for n, s in sorted(self.held_s.items()) if s}
        return {
            "kinds": {name: tally.plain() for name, tally in sorted(self.kinds.items())},
            "contact_before_flag": round(float(np.mean(self.before_flag)), 4) if self.before_flag else None,
            "code_changes_a_second_of_hold": per_second,
            "the_same_after_a_vote": {
                str(n): round(self.voted_changes.get(n, 0) / s, 4) for n, s in sorted(self.held_s.items()) if s
            },
            "events_a_minute_of_hold": round(self.held_events / minutes, 3) if minutes else None,
            "events_a_recording": {"median": float(np.median(self.events)), "most": max(self.events)},
        }


def score(
    folder: Path, labels: Iterable[Labelled], open_one: Callable[[Path], tuple[Source, Settings]],
    window: float = WINDOW, watch: Callable[[list[str]], Iterable[str]] = iter,
) -> Score:  # fmt: skip
    """Run every labelled recording through the pipeline and count.

    Arguments: ``open_one`` opens a recording and returns its settings; ``window`` [s] of a match; ``watch`` passes the
    names on and may show progress. If the labels of a recording name a kind for one finger, that kind is judged on all
    its labelled fingers.

    Raises:
        InputError: a missing recording, or a missing labelled finger.
    """
    total, by_name = Score(), dict[str, list[Labelled]]()
    for label in labels:
        by_name.setdefault(label.recording, []).append(label)
    for name in watch(list(by_name)):
        fingers = by_name[name]
        source, settings = open_one(_find(folder, name))
        seen = Watched()
        pipeline.run(source, settings, [seen])
        total.events.append(len(seen.events))
        for label in fingers:
            if label.finger >= len(source.arrays):
                raise InputError(f"{name}: {len(source.arrays)} fingers; the labels have finger {label.finger}")
            _judge(total, seen, label, source, window)
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
        calmer = [t for t in seen.voted_changes.get(array.name, []) if start <= t <= stop]
        total.voted_changes[label.finger] = total.voted_changes.get(label.finger, 0) + len(calmer)
        total.held_events += sum(start <= t <= stop for t, _ in mine)


def _find(folder: Path, name: str) -> Path:
    for suffix in SUFFIXES:
        path = folder / f"{name}{suffix}"
        if path.is_file():
            return path
    raise InputError(f"no recording {folder / name} with a suffix of {', '.join(SUFFIXES)}")
