"""The words and tables of section 1: orders, fewest evaluations, corrected kinks, what accuracy= keeps."""

from typing import Any

import numpy as np

from cnnsim.prototyping.accuracy.work_precision import Row
from tests.benchmarks.accuracy.random_cases import ACCURACIES

_SCHEMES = ("euler", "exponential-euler", "heun", "rk4")

_TRUTH = """\
The truth of a linear template is its solution to 1e-10; of delays and layers it is Heun's steps of 1/500 and 1/1000,
extrapolated. Observed orders, from the shortest steps above rounding, and the fewest evaluations of A\\*y:"""

_ORDERS = """\
Kinks bring every fixed step down to order 2, rk4 as well, whose errors are still the smallest for the work. Euler is
for runs that only have to settle."""

_CORRECTED = """\
**Corrected kinks.** In a step in which an output reaches -1 or +1, rk4 misses a part of the integral of that output,
which a cubic through the ends of the step gives. Adding it to the neighbours (`cnnsim/accuracy/corrected_rk4.py`) makes
the order 3 and each error 10 to 100 times smaller for the same steps: `accuracy=` uses it for a linear template on one
grid of up to 16 384 cells."""

_KEPT = """\
**What `accuracy=` keeps**, of random templates, pictures, boundaries and times whose seeds were never used to choose
anything:

| asked for | kept | missed by more than 3 x and unsaid | error below the estimate | time to the best by hand |
|---|---|---|---|---|"""

_COST = """\
{cases} cases of each on 2 x 2 to 13 x 13 cells, against the exact flow from kink to kink
(`tests/oracles/exact_transient.py`); {hand} of them by hand too: every scheme with 15 steps, of which the cheapest that
just keeps the accuracy counts (by hand the answer is known). Times are of the processor, median; over all accuracies
{median:.2g} x."""


def fewest(rows: list[Row], accuracy: float | str) -> float:
    """The fewest evaluations that reach an accuracy, or all signs; NaN if none does."""
    if isinstance(accuracy, str):
        good = [row.evaluations for row in rows if row.signs == 1]
    else:
        good = [row.evaluations for row in rows if row.error <= accuracy]
    return float(min(good, default=np.nan))


def _order(rows: list[Row], scheme: str) -> float:
    """The slope of the last errors above rounding, of the cpu backend in float64."""
    points = sorted((r.step, r.error) for r in rows if (r.backend, r.dtype, r.scheme) == ("cpu", "float64", scheme))
    points = [(h, e) for h, e in points if e > 1e-11][:4]
    if len(points) < 3:
        return float("nan")
    h, error = np.log(points).T
    return float(np.polyfit(h, error, 1)[0])


def text(found: dict[str, list[Row]], tries: list[Any], hand: list[Any]) -> str:
    """The paragraphs of the section."""
    lines = [_TRUTH, "", "| template | " + " | ".join(_SCHEMES) + " | for 1e-3 | for 1e-6 | for all signs |"]
    lines.append("|---" * (len(_SCHEMES) + 4) + "|")
    for name, rows in found.items():
        orders = " | ".join(f"{_order(rows, scheme):.1f}" for scheme in _SCHEMES)
        needs = " | ".join(f"{fewest(rows, accuracy):g}" for accuracy in (1e-3, 1e-6, "binary"))
        lines.append(f"| {name} | {orders} | {needs} |".replace("nan", "none"))
    lines += ["", _ORDERS, "", _CORRECTED, "", _KEPT]
    lines += [_row(accuracy, tries, hand) for accuracy in ACCURACIES]
    signs = [row for row in tries if row["accuracy"] == "binary"]
    wrong, silent = sum(row["error"] > 0 for row in signs), sum(row["silent"] > 0 for row in signs)
    lines += [f"| binary | {1 - wrong / len(signs):.1%} | {silent} | | |", ""]
    median = float(np.median([row["times"] for row in hand if row.get("times")]))
    lines.append(_COST.format(cases=len(signs), hand=len({row["seed"] for row in hand}), median=median))
    return "\n".join(lines)


def _row(accuracy: float, tries: list[Any], hand: list[Any]) -> str:
    rows = [row for row in tries if row["accuracy"] == accuracy]
    error, said = (np.array([row[key] for row in rows]) for key in ("error", "estimate"))
    ratios = [row["times"] for row in hand if row["accuracy"] == accuracy and row["times"]]
    below = error <= np.maximum(said, 1e-11)
    silent = int((error > 3 * np.maximum(accuracy, said)).sum())
    cost = f"{np.median(ratios):.1f} x" if ratios else "none by hand"
    return f"| {accuracy:.0e} | {np.mean(error <= accuracy):.1%} | {silent} | {below.mean():.1%} | {cost} |"
