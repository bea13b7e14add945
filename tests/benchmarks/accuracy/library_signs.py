"""Section 1b, the library: the signs of accuracy="binary" against exact ones on pictures of 128 x 128, and its time."""

from collections.abc import Iterator
from dataclasses import replace
from time import process_time
from typing import Any

import numpy as np

from cnnsim import InputError, library
from cnnsim.library.catalogue import run_example
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.support import Array
from cnnsim.support.command_line import watched
from tests.benchmarks.accuracy.section import Section
from tests.kits.library import ANSWERS
from tests.oracles.pictures import Case

SIDE = 128
_SLOW = 3.0
"""Times the default, beyond which the page says how a template was solved."""
_GREY = 0.02
"""Grey outputs nearer to 0 than this have no sign."""

_TEXT = """\
Each of the {number} templates on its first worked picture, mirrored at its edges until it fills {side} x {side} cells.
The exact signs are those of the definition (`tests/oracles`); where it has no answer on such a picture, or the duration
is a part of the template, those of a run by a quarter of the step in float64 ("runs"). Mirrored pictures have cells on
a separatrix, whose exact sign no run knows. Times are of the processor, of the default and of `accuracy="binary"`.

{right} of {judged} templates have all signs right. Others: {wrong}.

Median time against the default: {median:.2g} x. {slow} take more than three times as long:

{slow_ones}

| template | wrong | of these undecided | undecided | truth | default [ms] | binary [ms] | ratio |
|---|---|---|---|---|---|---|---|
{table}"""


def section() -> Section:
    """Measure all templates of the library."""
    names = library.names()
    rows = list(watched(_rows(names), "signs of the library", len(names)))
    right = sum(not row["wrong"] for row in rows)
    wrong = ", ".join(f"{r['template']} ({r['wrong']} wrong, {r['named']} undecided)" for r in rows if r["wrong"])
    table = "\n".join(
        f"| {row['template']} | {row['wrong']} | {row['named']} | {row['undecided']} | {row['truth']} | "
        f"{row['default_ms']:.3g} | {row['binary_ms']:.3g} | {_ratio(row):.2g} |"
        for row in rows
    )
    slow = sorted((row for row in rows if _ratio(row) > _SLOW), key=_ratio, reverse=True)
    median = float(np.median([_ratio(row) for row in rows]))
    slow_ones = "\n".join(f"- {row['template']}, {_ratio(row):.2g} x: {row['how']}" for row in slow) or "none"
    answer = (
        f"All signs are right in {right} of {len(rows)} templates, on pictures of up to {SIDE} x {SIDE} cells. "
        f"That takes {median:.2g} x the time of the default (median)."
    )
    words = _TEXT.format(
        number=len(names), side=SIDE, right=right, judged=len(rows), wrong=wrong or "none", median=median,
        slow=len(slow), slow_ones=slow_ones, table=table,
    )  # fmt: skip
    return Section("library", "Signs of the library", answer, words, rows)


def _ratio(row: dict[str, Any]) -> float:
    return float(row["binary_ms"] / row["default_ms"])


def _rows(names: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the signs and times of each template; templates that refuse an accuracy are skipped."""
    for name in names:
        entry = library.load(name)
        example, times = large(entry.examples[0], SIDE), []
        try:
            for _ in range(2):  # the first runs compile
                start = process_time()
                run_example(entry, example)
                middle = process_time()
                found = run_example(entry, example, accuracy="binary")
                times.append((middle - start, process_time() - middle))
        except InputError:
            continue
        exact, truth = _exact(entry, example, found.y)
        differs = (np.sign(exact) != np.sign(found.y)) & (np.abs(exact) > _GREY)
        undecided = np.zeros(differs.shape, bool)
        undecided[tuple(found.undecided.T)] = True
        default, binary = (1e3 * min(way) for way in zip(*times, strict=True))
        yield {
            "template": name, "wrong": int(differs.sum()), "named": int((differs & undecided).sum()),
            "undecided": int(undecided.sum()), "default_ms": default, "binary_ms": binary, "truth": truth,
            "how": str(found.how).split(": ", 1)[1],
        }  # fmt: skip


def large(example: Example, side: int) -> Example:
    """Return a worked example with its planes mirrored at their edges: copies side by side would make new ties."""

    def tiled(plane: Array | None) -> Array | None:
        if plane is None or np.ndim(plane) < 2:
            return plane
        beyond = [(0, max(0, side - n)) for n in plane.shape[-2:]]
        return np.pad(plane, [*((0, 0) for _ in plane.shape[:-2]), *beyond], "symmetric")[..., :side, :side]

    planes = {name: tiled(getattr(example, name)) for name in ("input", "state", "output", "mask", "bias")}
    return replace(example, **planes)  # type: ignore[arg-type]  # planes all


def _exact(entry: LibraryEntry, example: Example, like: Array) -> tuple[Array, str]:
    mask = None if example.mask is None else example.mask > 0
    try:
        # definitions of grey answers solve systems that are too large here; others give the end, not a time on the way
        none = example.tolerance is not None or entry.duration != "settled"
        answer = np.empty(0) if none else ANSWERS[entry.name](Case(example.input, example.state, mask, example.bias))
        if answer.shape == like.shape and np.isfinite(answer).all():
            return answer, "definition"
    except (KeyError, ValueError, AssertionError):  # it has answers for small pictures only
        pass
    plan = run_example(entry, example).plan
    steps: Any = {} if plan.scheme is None or plan.cell == "discrete-time" else {"step": plan.step / 4}
    return run_example(entry, example, dtype="float64", **steps).y, "runs"
