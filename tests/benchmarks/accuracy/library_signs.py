"""Section 1b, the library: the signs of accuracy="binary" against exact ones at 256 x 256, and its time."""

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

SIDE = 256
_GREY = 0.02
"""Outputs of grey answers nearer to 0 than this are not told apart by their sign."""

_TEXT = """\
Each of the {number} templates on its first worked picture, laid side by side until it fills {side} x {side} cells. The
exact signs are the definition's (`tests/oracles`), which knows nothing of states and steps. "same" compares two runs,
by half the step, where the definition has no answer on such a picture (it says "runs"). Times are of the processor,
in-turn, of the default and of `accuracy="binary"`.

{right} of {judged} templates have all signs right; {named} more have named all of the cells that are wrong. Median time
against the default: {median:.2g} x. {slow} take more than twice as long: where neither a closed form nor theory knows
that there is one end, two runs by different steps have to agree.

| template | signs wrong | of these named | truth | default [ms] | binary [ms] | ratio |
|---|---|---|---|---|---|---|
{table}"""


def section() -> Section:
    """Measure all templates of the library."""
    names = library.names()
    rows = list(watched(_rows(names), "library at 256 x 256", len(names)))
    judged = [row for row in rows if row["wrong"] != ""]
    right = sum(row["wrong"] == 0 for row in judged)
    named = sum(row["wrong"] > 0 and row["wrong"] == row["named"] for row in judged)
    ratios = [row["binary_ms"] / row["default_ms"] for row in judged]
    table = "\n".join(
        f"| {row['template']} | {row['wrong']} | {row['named']} | {row['truth']} | {row['default_ms']:.3g} | "
        f"{row['binary_ms']:.3g} | {row['binary_ms'] / row['default_ms']:.2g} |"
        if row["wrong"] != ""
        else f"| {row['template']} | | | {row['truth']} | | | |"
        for row in rows
    )
    median = float(np.median(ratios))
    answer = (
        f"Binary outputs of the library: all {SIDE} x {SIDE} signs right in {right} of {len(judged)} templates, for "
        f"{median:.2g} x the time of the default (median)."
    )
    words = _TEXT.format(
        number=len(rows), side=SIDE, right=right, judged=len(judged), named=named, median=median, table=table,
        slow=sum(ratio > 2 for ratio in ratios),
    )  # fmt: skip
    return Section("library", "Signs of the library", answer, words, rows, lambda figure: _draw(figure, judged), (9, 4))


def _rows(names: list[str]) -> Iterator[dict[str, Any]]:
    for name in names:
        entry = library.load(name)
        yield {"template": name, "wrong": "", "named": "", "default_ms": "", "binary_ms": "", "truth": ""} | row(entry)


def row(entry: LibraryEntry, side: int = SIDE) -> dict[str, Any]:
    """Return what one template's signs and times are on its first worked picture, made as large as that."""
    example = large(entry.examples[0], side)
    choices = {"accuracy": "binary"}
    try:
        run_example(entry, example)  # the first run compiles
        start = process_time()
        run_example(entry, example)
        middle = process_time()
        found = run_example(entry, example, **choices)
        end = process_time()
    except InputError as error:
        return {"truth": f"refused: {error}"}
    exact, truth = _exact(entry, example, found.y)
    wrong = (np.sign(exact) != np.sign(found.y)) & (np.abs(exact) > _GREY)
    unsure = np.zeros(wrong.shape, bool)
    unsure[tuple(found.undecided.T)] = True
    return {
        "wrong": int(wrong.sum()), "named": int((wrong & unsure).sum()), "default_ms": 1e3 * (middle - start),
        "binary_ms": 1e3 * (end - middle), "truth": truth,
    }  # fmt: skip


def large(example: Example, side: int) -> Example:
    """Return a worked example with its planes laid side by side, and its output with them."""

    def tiled(plane: Array | None) -> Array | None:
        if plane is None or np.ndim(plane) < 2:
            return plane
        times = [-(-side // n) for n in plane.shape[-2:]]
        return np.tile(plane, (*(1 for _ in plane.shape[:-2]), *times))[..., :side, :side]

    planes = {name: tiled(getattr(example, name)) for name in ("input", "state", "output", "mask", "bias")}
    return replace(example, **planes)  # type: ignore[arg-type]  # planes all


def _exact(entry: LibraryEntry, example: Example, like: Array) -> tuple[Array, str]:
    mask = None if example.mask is None else example.mask > 0
    try:
        grey = example.tolerance is not None  # whose definitions solve systems that are too large here
        answer = np.empty(0) if grey else ANSWERS[entry.name](Case(example.input, example.state, mask, example.bias))
        if answer.shape == like.shape and np.isfinite(answer).all():
            return answer, "definition"
    except (KeyError, ValueError, AssertionError):  # it has an answer to small pictures alone
        pass
    step = run_example(entry, example).plan.step
    return run_example(entry, example, step=step / 2, dtype="float64").y, "runs"


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    ratios = sorted(row["binary_ms"] / row["default_ms"] for row in rows)
    axes.semilogy(ratios, np.arange(1, len(ratios) + 1) / len(ratios), drawstyle="steps-post")
    axes.set(xscale="log", yscale="linear", ylabel="share of the templates", ylim=(0, 1.02))
    axes.set_xlabel('time of accuracy="binary" over that of the default')
    axes.axvline(1, color="grey", linewidth=0.8)
