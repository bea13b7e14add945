"""The words and tables of section 1: orders, fewest evaluations, the ideas tried, what accuracy= keeps."""

from typing import Any

import numpy as np

from cnnsim.prototyping.accuracy.work_precision import Row
from tests.benchmarks.accuracy.random_cases import ACCURACIES

_SCHEMES = ("euler", "exponential-euler", "heun", "rk4")

_TRUTH = """\
The truth is the exact flow: between two kinks (a cell that enters or leaves its saturation) a linear template is a
linear system, which the matrix exponential solves, and the kinks are located to 1e-15. Dense exponentials, DOP853 and
thirty digits of mpmath agree with it to 1e-11 and better (`tests/cnnsim/accuracy`). Of delays and layers it is Heun's
steps of 1/500 and 1/1000, extrapolated. Observed orders, from the shortest steps above rounding, and the fewest
evaluations of A\\*y:"""

_ORDERS = """\
Kinks bring every fixed step down to order 2, rk4 as well, whose errors are still the smallest for the work. Euler is
for runs that only have to settle."""

_IDEAS = """\
**Three ideas tried.** In a step in which an output meets -1 or +1, rk4 misses a part of the integral of that output,
which a cubic through the ends of the step knows. Adding it to the neighbours (`cnnsim/accuracy/corrected_loops.py`)
costs next to nothing, makes the order 3 and each error 10 to 100 times smaller for the same steps: `accuracy=` takes it
for a linear template on one grid of up to 65 536 cells. A scheme that steps exactly to each kink needs a series of
about ten evaluations a kink and reaches 1e-13 whatever is asked: {kinks}. Compiled, it costs less than short steps
where there are few kinks and many digits are wanted, and is taken there (`explain` says up to how many kinks). The
exponential integrator of order 2 (ETD2RK, the crosses) gains nothing over
Heun: the leak that it treats exactly is no stiffer than the coupling, which it does not."""

_KEPT = """\
**What `accuracy=` keeps**, of random templates, pictures, boundaries and times whose seeds were never used to choose
anything:

| asked for | kept | missed by more than 3 x and unsaid | estimate within 10 x | time to the best by hand |
|---|---|---|---|---|"""

_COST = """\
{cases} cases of each on 2 x 2 to 13 x 13 cells, {hand} of them by hand too: every scheme with 15 steps, of which the
cheapest that just keeps the accuracy counts (it knows the answer). Times are of the processor, median; over all
accuracies {median:.2g} x. Two or three corrected runs that agree cost about as much as one plain run that is known to
suffice; where much is asked for, going from kink to kink costs less than any step. On grids of 64 x 64 and larger,
where the call no longer counts, 1e-4 costs about as much as the best setting by hand, 1e-3 two to three times as much,
1e-1 and 1e-2 three to six times, the more the larger: among so many cells there nearly always is one near a ridge,
which a run that knows the answer may take the right way by luck, and one that does not has to look at twice."""


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


def text(found: dict[str, list[Row]], ideas: Any, tries: list[Any], hand: list[Any]) -> str:
    """The paragraphs of the section."""
    lines = [_TRUTH, "", "| template | " + " | ".join(_SCHEMES) + " | for 1e-3 | for 1e-6 | for all signs |"]
    lines.append("|---" * (len(_SCHEMES) + 4) + "|")
    for name, rows in found.items():
        orders = " | ".join(f"{_order(rows, scheme):.1f}" for scheme in _SCHEMES)
        needs = " | ".join(f"{fewest(rows, accuracy):g}" for accuracy in (1e-3, 1e-6, "binary"))
        lines.append(f"| {name} | {orders} | {needs} |".replace("nan", "none"))
    kinks = "; ".join(f"{name} {points[0][1]} evaluations" for name, points in ideas.items() if points)
    lines += ["", _ORDERS, "", _IDEAS.format(kinks=kinks), "", _KEPT]
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
    near = ((said <= 10 * error) & (said >= error / 10)) | (np.maximum(said, error) < 1e-11)
    silent = int((error > 3 * np.maximum(accuracy, said)).sum())
    cost = f"{np.median(ratios):.1f} x" if ratios else "none by hand"
    return f"| {accuracy:.0e} | {np.mean(error <= accuracy):.1%} | {silent} | {near.mean():.1%} | {cost} |"
