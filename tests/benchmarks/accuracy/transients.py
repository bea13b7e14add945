"""Section 1, transients: work and precision of every scheme, step, dtype and backend, and what accuracy= keeps."""

from dataclasses import asdict
from typing import Any

import numpy as np

from cnnsim import backends
from cnnsim.prototyping.accuracy.plot import draw
from cnnsim.prototyping.accuracy.work_precision import STEPS, Row, measured, reference_state, settings
from cnnsim.support.command_line import watched
from tests.benchmarks.accuracy.families import families
from tests.benchmarks.accuracy.random_cases import ACCURACIES, kept
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.accuracy.transients_text import fewest, text

FRESH_SEEDS = 900_000
"""From here on no seed was looked at when the settings were chosen."""
_OTHERS = (0.4, 0.1, 0.025)
"""Steps that are tried on the backends besides cpu, whose errors are the same."""


def section(cases: int) -> Section:
    """Measure eight templates, and a number of random cases."""
    found: dict[str, list[Row]] = {}
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
        f"Transients: three digits cost {costs[1e-3] / costs['binary']:.2g} x the evaluations of binary outputs, six "
        f"{costs[1e-6] / costs['binary']:.2g} x (medians over eight templates, the best setting for each)."
    )
    return Section(
        "transients", "1. Transients", answer, text(found, tries, hand), table,
        lambda figure: _draw(figure, found), (13.0, 22.0),
    )  # fmt: skip


def _there(name: str) -> bool:
    from cnnsim import InputError

    try:
        return backends.get(name) is not None
    except InputError:
        return False


def _near(step: float) -> bool:
    return any(abs(step - other) < 1e-12 for other in _OTHERS)


def _costs(found: dict[str, list[Row]]) -> dict[Any, float]:
    wanted = ("binary", *ACCURACIES)
    return {a: float(np.nanmedian([fewest(rows, a) for rows in found.values()])) for a in wanted}


def _draw(figure: Any, found: dict[str, list[Row]]) -> None:
    axes = figure.subplots(len(found), 2)
    for (name, rows), (left, right) in zip(found.items(), axes, strict=True):
        draw(rows, left, "evaluations", name)
        draw(rows, right, "seconds", name)
        left.set_ylim(1e-15, 30)
        right.set_ylim(1e-15, 30)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, ncols=4, loc="outside upper center")  # beside the curves, not over them
