"""Measure the robustness of a template: the share of wrong cells over errors of entries, bits of entries and noise."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.prototyping.robust.disturb import quantised, with_relative_errors
from cnnsim.prototyping.robust.error_rate import ErrorRate, error_rate_of
from cnnsim.prototyping.robust.margin import margin_of
from cnnsim.prototyping.robust.report import Curve, Robustness

SIGMAS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2)
BITS = tuple(range(3, 13))
NOISES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)

Track = Callable[[Iterable[tuple[str, float]]], Iterable[tuple[str, float]]]
"""Iterates over the levels and may report the progress."""


def measure(
    entry: LibraryEntry, *, draws: int = 40, seed: int = 0, track: Track = iter, shown: Sequence[Example] = ()
) -> Robustness:
    """Measure the robustness of a library template; the same seed gives the same numbers.

    Templates without neighbours, from black and white, are measured on all their neighbourhoods, others by whole runs
    on their own examples; all on what is ``shown`` to them (see `error_rate.shown_to`), if something is.
    """
    error_rate = error_rate_of(entry, seed, shown)
    levels = [*(("entries", s) for s in SIGMAS), *(("bits", b) for b in BITS), *(("noise", s) for s in NOISES)]
    shares = {level: _shares(entry, error_rate, level, draws, seed) for level in track(levels)}

    def curve(kind: str) -> Curve:
        found = {level: value for (which, level), value in shares.items() if which == kind}
        means, worst = ([float(f(v)) for v in found.values()] for f in (np.mean, np.max))
        return Curve(tuple(found), tuple(means), tuple(worst))

    return Robustness(
        entry.name, margin_of(entry), error_rate.what, curve("entries"), curve("bits"), curve("noise"), draws, seed
    )


def _shares(entry: LibraryEntry, error_rate: ErrorRate, level: tuple[str, float], draws: int, seed: int) -> list[float]:
    kind, size = level
    if kind == "bits":
        return [error_rate.share_of_wrong(quantised(entry.network, int(size)), 0.0, np.random.default_rng(seed))]
    found = []
    for draw in range(draws):
        rng = np.random.default_rng([seed, draw])  # one draw is the same error at every level, only larger
        if kind == "noise":
            found.append(error_rate.share_of_wrong(entry.network, size, rng))
        else:
            found.append(error_rate.share_of_wrong(with_relative_errors(entry.network, size, rng), 0.0, rng))
    return found
