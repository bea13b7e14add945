"""Score of simulated grasps and idle noise: events against onsets in closed form."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tactile import pipeline
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.events.event import Event, EventLog
from tactile.score.baselines import baseline
from tactile.score.labels import Labelled, LabelledSource
from tactile.score.match import WINDOW, Tally
from tactile.score.partial_slip import NOISE, NOISY, Grasp, grasp
from tactile.settings import Settings

KINDS = ("contact", "release", "slip")
IDLE_RATE, IDLE_SIDE = 200.0, 4
"""Frames per second, and taxels per side, of the idle array."""


@dataclass
class SimulatedScore:
    """Score of many simulated grasps: tallies by kind, those of the baseline under "baseline: ...".

    ``late`` [s] from a known gross slip to its report; ``before``: of the gross slips, whether an incipient slip was
    reported before; ``idle`` events in ``idle_minutes``.
    """

    kinds: dict[str, Tally] = field(default_factory=dict)
    late: list[float] = field(default_factory=list)
    before: list[bool] = field(default_factory=list)
    idle: int = 0
    idle_minutes: float = 0.0

    def plain(self) -> dict[str, Any]:
        """Return all as plain data."""
        told = [float(point) for point in np.percentile(self.late, (5, 50, 95))] if self.late else None
        return {
            "kinds": {name: tally.plain() for name, tally in sorted(self.kinds.items())},
            "slip_told_after_s": told,
            "incipient_before_gross_slip": round(float(np.mean(self.before)), 4) if self.before else None,
            "idle_events": self.idle if self.idle_minutes else None,
            "idle_minutes": self.idle_minutes or None,
        }


def score_grasps(
    seeds: Iterable[int], settings: Callable[[FrameStream], Settings], idle_minutes: float = 0.0,
    window: float = WINDOW,
) -> SimulatedScore:  # fmt: skip
    """Run the grasp of every seed, then minutes of pure noise, through the pipeline and count."""
    total = SimulatedScore(idle_minutes=idle_minutes)
    for seed in seeds:
        one = grasp(seed)
        source = one.source()
        _judge(total, one, source, _events(source, settings(source)), window)
    if idle_minutes:
        source = idle(idle_minutes)
        total.idle = len(_events(source, settings(source)))
    return total


def labelled_grasps(seeds: Iterable[int]) -> Iterator[LabelledSource]:
    """Yield the grasp of every seed with its known onsets as labels."""
    for seed in seeds:
        one = grasp(seed)
        name = f"grasp {seed}"
        yield LabelledSource(name, one.source(), [Labelled(name, 0, one.truth, None, None)])


def _events(source: FrameStream, settings: Settings) -> list[Event]:
    log = EventLog()
    pipeline.run(source, settings, [lambda report: log.add(report.events, report.ended)])
    return log.events


def _judge(total: SimulatedScore, one: Grasp, source: FrameStream, events: list[Event], window: float) -> None:
    frames = list(source)
    t, values = np.array([frame.t for frame in frames]), np.array([frame.values for frame in frames])
    plain = baseline(t, values, 1.0)
    mine = [(event.t, event.kind) for event in events]
    for kind in KINDS:
        known = [one.truth[kind]] if kind in one.truth else []
        for prefix, found in (("", mine), ("baseline: ", plain)):
            tally = total.kinds.setdefault(prefix + kind, Tally())
            tally.add([time for time, what in found if what == kind], known, window)
    if "slip" in one.truth:
        slid, pulled = one.truth["slip"], one.truth["tangential_load"]
        slips = [event for event in events if event.kind == "slip" and abs(event.t - slid) <= window]
        total.late += [min(event.told - slid for event in slips)] if slips else []
        total.before.append(any(event.kind == "incipient_slip" and pulled <= event.told < slid for event in events))


def idle(minutes: float, seed: int = 0) -> FrameStream:
    """Return an untouched array with the noise of `partial_slip.grasp`, one taxel far noisier."""
    array = TaxelArray("idle", IDLE_SIDE, IDLE_SIDE, 3e-3, 0.0, quantity="force")
    count = round(60 * minutes * IDLE_RATE)
    every = np.ones(array.shape, bool)

    class IdleNoise:
        def __iter__(self) -> Iterator[Frame]:
            rng = np.random.default_rng((seed, 2))
            noise = np.broadcast_to(NOISE, (*array.shape, 3)).copy()
            noise[1, 2] = NOISY
            for n in range(count):
                yield Frame(0, n / IDLE_RATE, n, rng.standard_normal(noise.shape) * noise, every)

    return FrameStream("idle", (array,), None, count, IdleNoise(), Provenance(untared=True))
