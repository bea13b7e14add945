"""Robustness of the events: precision, recall and false shear events of recordings and grasps under perturbations."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from tactile import pipeline
from tactile.core.source import Source
from tactile.events.event import EventLog
from tactile.score.labels import LabelledSource
from tactile.score.match import WINDOW, Tally
from tactile.score.perturb import Perturbation, perturbed
from tactile.settings import Settings

SHEAR_KINDS = ("tangential_load", "pull", "twist", "spread", "pinch", "incipient_slip", "slip")
"""Kinds of events that are false before a known onset of a tangential load or a slip, and after the contact."""


@dataclass
class Robustness:
    """Result of one perturbation: tallies by kind, false shear events, and minutes of all fingers."""

    kinds: dict[str, Tally] = field(default_factory=dict)
    false_shear: int = 0
    minutes: float = 0.0

    def add(self, case: LabelledSource, how: Perturbation, settings: Settings, window: float) -> None:
        """Run a perturbed case through the pipeline and count.

        The ``window`` [s] of a match grows with the tempo of slow recordings. A known time in a gap of the frames may
        be matched until the first frame after it.
        """
        source, log = perturbed(case.source, how), EventLog()
        pipeline.run(source, settings, [lambda report: log.add(report.events, report.ended)])
        window *= max(1.0, 1 / how.tempo)
        times: dict[int, list[float]] = {}
        for frame in source:
            times.setdefault(frame.finger, []).append(frame.t)
        for label in case.labels:
            name, stamps = source.arrays[label.finger].name, times[label.finger]
            found = [event for event in log.events if event.finger == name]
            known = {kind: t / how.tempo for kind, t in label.times.items()}
            for kind, t in known.items():
                late = min((one for one in stamps if one >= t), default=t) - t
                onsets = [event.t - min(max(event.t - t, 0.0), late) for event in found if event.kind == kind]
                self.kinds.setdefault(kind, Tally()).add(onsets, [t], window)
            shear = [known[kind] for kind in ("tangential_load", "slip") if kind in known]
            since = min(shear, default=float("inf")) - window
            until = known.get("release", float("inf")) + window
            self.false_shear += sum(event.kind in SHEAR_KINDS and not since <= event.t <= until for event in found)
            self.minutes += (stamps[-1] - stamps[0]) / 60

    def plain(self) -> dict[str, Any]:
        """Return all as plain data."""
        return {
            "kinds": {name: tally.plain() for name, tally in sorted(self.kinds.items())},
            "false_shear_events_a_minute": round(self.false_shear / self.minutes, 3) if self.minutes else None,
        }


def score_perturbed(
    cases: Sequence[LabelledSource], chosen: Iterable[Perturbation], settings: Callable[[Source], Settings],
    window: float = WINDOW,
) -> Iterator[tuple[str, Robustness]]:  # fmt: skip
    """Yield the name and the result of every perturbation."""
    for how in chosen:
        total = Robustness()
        for case in cases:
            total.add(case, how, settings(case.source), window)
        yield how.name, total
