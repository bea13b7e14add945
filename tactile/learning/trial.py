"""Trial of learned detectors on recordings that they did not learn, next to the shipped detector and a baseline."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactile import pipeline
from tactile.core.source import Source
from tactile.events.detector_file import SHIPPED, shipped_detectors
from tactile.events.event import EventLog
from tactile.learning.collect import Example, known_times
from tactile.score.baselines import KINDS, baseline
from tactile.score.labels import LabelledSource
from tactile.score.match import Tally
from tactile.score.perturb import UNCHANGED, Perturbation, perturbed
from tactile.settings import Settings

FOLDS = 4
"""Most parts of the recordings, each of which is held out once."""
LEARNED, SHIPPED_ONE, BASELINE = "learned", "shipped", "baseline"
Row = dict[str, Tally]
"""Tallies of the detectors, by name."""


@dataclass(frozen=True)
class Held:
    """Fingers (recording, finger) that are held out, with the detector file that was learned from the others."""

    fingers: frozenset[tuple[str, str]]
    file: Path


def folds(examples: Sequence[Example], by: str) -> list[set[int]]:
    """Return the numbers of the examples that are held out together: by ``recording`` or by ``array``.

    Recordings with the event are dealt first, so that each part has some of both. A part is left out if the others
    have no event.
    """
    known = {getattr(one, by) for one in examples if one.known}
    groups = sorted({getattr(one, by) for one in examples}, key=lambda name: (name not in known, name))
    count = min(FOLDS, len(groups)) if by == "recording" else len(groups)
    parts = [set(groups[n::count]) for n in range(count)]
    held = [{n for n, one in enumerate(examples) if getattr(one, by) in part} for part in parts]
    return [
        part for part in held if any(one.known for n, one in enumerate(examples) if n not in part)
    ] if count > 1 else []  # fmt: skip


def made_by_shipped(kind: str) -> bool:
    """Return whether a shipped detector makes this kind of event."""
    return any(rule.kind == kind for file in shipped_detectors(SHIPPED) for rule in file.rules)


def trial(
    cases: Iterable[LabelledSource], held: Sequence[Held], kinds: tuple[str, str],
    settings: Callable[[Source], Settings], how: Perturbation,
) -> Row:  # fmt: skip
    """Return the tallies on perturbed recordings, each by the detector that did not learn it.

    ``kinds``: the kind in the labels, and that of the learned detector.
    """
    kind, own = kinds
    row = {LEARNED: Tally(), **({SHIPPED_ONE: Tally()} if made_by_shipped(kind) else {}),
           **({BASELINE: Tally()} if kind in KINDS else {})}  # fmt: skip
    for case in cases:
        source = perturbed(case.source, how)
        for part in held:
            if not any(name == case.name for name, _ in part.fingers):
                continue
            log = EventLog()
            chosen = replace(settings(case.source), programs=(str(part.file),))
            pipeline.run(source, chosen, [lambda report, log=log: log.add(report.events, report.ended)])  # type: ignore[misc]
            for finger, (known, _) in known_times(case, kind).items():
                array = source.arrays[finger]
                if (case.name, array.name) not in part.fingers:
                    continue
                mine = [event for event in log.events if event.finger == array.name]
                found = {name: [one.t for one in mine if one.kind == made]
                         for name, made in ((LEARNED, own), (SHIPPED_ONE, kind))}  # fmt: skip
                if BASELINE in row:
                    found[BASELINE] = _by_baseline(source, finger, kind)
                for name, tally in row.items():
                    tally.add(found[name], known)
    return row


def _by_baseline(source: Source, finger: int, kind: str) -> list[float]:
    frames = [frame for frame in source if frame.finger == finger]
    t, values = np.array([frame.t for frame in frames]), np.array([frame.values for frame in frames])
    inward = 1.0 if source.arrays[finger].quantity == "force" else -1.0
    return [time for time, what in baseline(t, values, inward) if what == kind]


def rows(
    cases: Sequence[LabelledSource], held: dict[str, list[Held]], kinds: tuple[str, str],
    settings: Callable[[Source], Settings], changes: Iterable[Perturbation],
) -> Iterator[tuple[str, Row]]:  # fmt: skip
    """Yield the rows of the table: recordings and arrays held out, then recordings held out and perturbed."""
    for by, parts in held.items():
        if parts:
            yield f"held-out {by}s", trial(cases, parts, kinds, settings, UNCHANGED)
    for how in changes:
        yield how.name, trial(cases, held["recording"], kinds, settings, how)
