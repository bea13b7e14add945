"""Best times of several ways to compute the same, in turn, so that a busy machine is unfair to none."""

from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any


def best_times(ways: Mapping[str, Callable[[], Any]], rounds: int = 5) -> dict[str, float]:
    """Seconds of the best of some rounds, each way once a round."""
    best: dict[str, float] = {}
    for _ in range(rounds):
        for name, way in ways.items():
            start = perf_counter()
            way()
            best[name] = min(best.get(name, float("inf")), perf_counter() - start)
    return best


def first_below(rows: list[tuple[float, float]], wanted: float) -> float:
    """The least cost of (cost, error) rows that reach an error; NaN if none does."""
    return min((cost for cost, error in rows if error <= wanted), default=float("nan"))
