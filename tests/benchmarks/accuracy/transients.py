"""Section 1, transients: work and precision of every scheme, step, dtype and backend, and what accuracy= keeps."""

from dataclasses import asdict
from typing import Any

import numpy as np

from cnnsim import backends
from cnnsim.prototyping.accuracy.plot import draw
from cnnsim.prototyping.accuracy.work_precision import STEPS, PrecisionRow, measured, reference_state, settings
from cnnsim.support.command_line import watched
from tests.benchmarks.accuracy.families import families
from tests.benchmarks.accuracy.random_cases import ACCURACIES, kept
from tests.benchmarks.accuracy.section import Section

FRESH_SEEDS = 900_000
"""From here on no seed was looked at when the settings were chosen."""
_OTHERS = (0.4, 0.1, 0.025)
"""Steps that are tried on the backends besides cpu, whose errors are the same."""


def section(cases: int) -> Section:
    """Measure eight templates, and a number of random cases."""
    found: dict[str, list[PrecisionRow]] = {}
    for name, given in families().items():
        exact, _ = reference_state(given)
        others = [b for b in backends.NAMES if b != "cpu" and _there(b)]
        tried = [s for s in settings(("cpu", *others), len(STEPS)) if s[0] == "cpu" or (s[3] in STEPS and _near(s[3]))]
        rows = [measured(given, exact, setting) for setting in watched(tried, name, len(tried))]
        found[name] = [row for row in rows if row is not None]
    tries = list(watched(kept(range(FRESH_SEEDS, FRESH_SEEDS + cases), hand=False), "random cases", cases * 9))
    hand = list(kept(range(FRESH_SEEDS, FRESH_SEEDS + max(1, cases // 40)), hand=True))
    table = [{"template": name, **asdict(row)} for name, rows in found.items() for row in rows]
    costs = _costs(found)
    answer = (
        f"Three digits cost {costs[1e-3] / costs['binary']:.2g} x the evaluations of binary outputs, six digits "
        f"{costs[1e-6] / costs['binary']:.2g} x. These are medians over eight templates."
    )
    return Section(
        "transients", "Transients", answer, _text(found, tries, hand), table,
        lambda figure: _draw(figure, found), (12.0, 6.4), _SEE,
    )  # fmt: skip


def _there(name: str) -> bool:
    from cnnsim import InputError

    try:
        return backends.get(name) is not None
    except InputError:
        return False


def _near(step: float) -> bool:
    return any(abs(step - other) < 1e-12 for other in _OTHERS)


def _costs(found: dict[str, list[PrecisionRow]]) -> dict[Any, float]:
    wanted = ("binary", *ACCURACIES)
    return {a: float(np.nanmedian([_fewest(rows, a) for rows in found.values()])) for a in wanted}


def _draw(figure: Any, found: dict[str, list[PrecisionRow]]) -> None:
    panels = figure.subplots(2, -(-len(found) // 2), sharex=True, sharey=True, squeeze=False).ravel()
    for (name, rows), axes in zip(found.items(), panels, strict=False):
        draw(
            [row for row in rows if row.backend == "cpu" and (row.dtype, row.scheme) in _SHOWN],
            axes,
            "evaluations",
            name,
        )
        axes.set_ylim(1e-15, 30)
        axes.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=9, ncols=5, loc="outside upper center")


_SEE = (
    "The lines fall with the order of the scheme. Only rk4 reaches six digits within 1000 evaluations, in three of the "
    "eight templates. In float32 the error stays above 1e-8."
)
_SHOWN = {("float64", scheme) for scheme in ("euler", "exponential-euler", "heun", "rk4")} | {("float32", "rk4")}
_SCHEMES = ("euler", "exponential-euler", "heun", "rk4")

_TRUTH = """\
The truth of a linear template is its solution to 1e-10; of delays and layers it is Heun's steps of 1/500 and 1/1000,
extrapolated. Observed orders, from the shortest steps above rounding, and the fewest evaluations of A\\*y:"""

_ORDERS = """\
Kinks bring every fixed step down to order 2, rk4 as well, whose errors are still the smallest for the work. Euler is
for runs that only have to settle."""

_CORRECTED = """\
**Corrected kinks.** In a step in which an output reaches -1 or +1, rk4 misses a part of the integral of that output,
which a cubic through the ends of the step gives. Adding it to the neighbours (`cnnsim/solver/corrected_rk4.py`) makes
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


def _fewest(rows: list[PrecisionRow], accuracy: float | str) -> float:
    """The fewest evaluations that reach an accuracy, or all signs; NaN if none does."""
    if isinstance(accuracy, str):
        good = [row.evaluations for row in rows if row.signs == 1]
    else:
        good = [row.evaluations for row in rows if row.error <= accuracy]
    return float(min(good, default=np.nan))


def _order(rows: list[PrecisionRow], scheme: str) -> float:
    """The slope of the last errors above rounding, of the cpu backend in float64."""
    points = sorted((r.step, r.error) for r in rows if (r.backend, r.dtype, r.scheme) == ("cpu", "float64", scheme))
    points = [(h, e) for h, e in points if e > 1e-11][:4]
    if len(points) < 3:
        return float("nan")
    h, error = np.log(points).T
    return float(np.polyfit(h, error, 1)[0])


def _text(found: dict[str, list[PrecisionRow]], tries: list[Any], hand: list[Any]) -> str:
    """The paragraphs of the section."""
    lines = [_TRUTH, "", "| template | " + " | ".join(_SCHEMES) + " | for 1e-3 | for 1e-6 | for all signs |"]
    lines.append("|---" * (len(_SCHEMES) + 4) + "|")
    for name, rows in found.items():
        orders = " | ".join(f"{_order(rows, scheme):.1f}" for scheme in _SCHEMES)
        needs = " | ".join(f"{_fewest(rows, accuracy):g}" for accuracy in (1e-3, 1e-6, "binary"))
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
