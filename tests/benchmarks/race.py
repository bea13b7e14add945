"""Alternating timing: each candidate runs once a round and its best round counts, so noise affects all alike."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

PAUSE = 0.25
TURN = 0.1
"""Seconds for which a short runner's turn is repeated: after a pause caches are cold, and cores have to wake up."""


@dataclass
class Row:
    """One line of the table. ``value`` in ``unit``; ``ratios`` to others of the same race; ``share`` of a limit."""

    work: str
    who: str
    value: float
    unit: str
    target: str = ""
    ratios: dict[str, float] = field(default_factory=dict)
    note: str = ""


def race(runners: Mapping[str, Callable[[], object]], rounds: int = 5) -> dict[str, float]:
    """Return the best seconds of each runner; one round before the first is not counted (it compiles).

    Threads of the one before, which may wait in a loop for more work, are given the time to go to sleep.
    """
    best = dict.fromkeys(runners, float("inf"))
    for counted in range(rounds + 1):
        for name, run in runners.items():
            time.sleep(PAUSE if len(runners) > 1 else 0.0)
            begun = time.perf_counter()
            while True:
                start = time.perf_counter()
                run()
                end = time.perf_counter()
                if counted:
                    best[name] = min(best[name], end - start)
                if end - begun >= TURN:
                    break
    return best


def versus(seconds: Mapping[str, float], who: str) -> dict[str, float]:
    """Return how many times faster ``who`` was than each of the others."""
    return {name: time / seconds[who] for name, time in seconds.items() if name != who}
