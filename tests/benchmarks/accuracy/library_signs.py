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

SIDES = (256, 128, 64)
"""Of the pictures; a smaller one where the larger would take too long."""
_MOST_SECONDS = 0.6
"""That the default and binary runs of a template may take together, by what they take at the smallest side."""
_PUSHES = 6
"""Of a picture whose exact signs are in doubt."""
_GREY = 0.02
"""Outputs of grey answers nearer to 0 than this are not told apart by their sign."""

_TEXT = """\
Each of the {number} templates on its first worked picture, mirrored at its edges until it fills {side} x {side} cells
({smaller} of them fewer, which the table says: both runs together are given {most:g} s). The exact signs are the
definition's (`tests/oracles`), which knows nothing of states and steps; where it has no answer on such a picture, or
the time is a part of the template, they are those of a run by a quarter of the step in float64 (it says "runs").
Times are of the processor, of the default and of `accuracy="binary"`.

{right} of {judged} templates have all signs right; {named} more have named all of the cells that are wrong. Median time
against the default: {median:.2g} x. {slow} take more than twice as long: where neither a closed form nor theory knows
that there is one end, two runs by different steps have to agree. Not judged: {refused}.
{open_cells} cells of {open_templates} templates are tied (their exact sign changes if the picture is pushed by 1e-13);
{open_named} of them are named.

| template | side | signs wrong | of these named | tied | truth | default [ms] | binary [ms] | ratio |
|---|---|---|---|---|---|---|---|---|
{table}"""


def section() -> Section:
    """Measure all templates of the library."""
    names = library.names()
    rows = list(watched(_rows(names), "signs of the library", len(names)))
    judged = [row for row in rows if row["wrong"] != ""]
    right = sum(row["wrong"] == 0 for row in judged)
    named = sum(row["wrong"] > 0 and row["wrong"] == row["named"] for row in judged)
    ratios = [row["binary_ms"] / row["default_ms"] for row in judged]
    table = "\n".join(
        f"| {row['template']} | {row['side']} | {row['wrong']} | {row['named']} | {row['open']} | {row['truth']} | "
        f"{row['default_ms']:.3g} | {row['binary_ms']:.3g} | {row['binary_ms'] / row['default_ms']:.2g} |"
        if row["wrong"] != ""
        else f"| {row['template']} | {row['side']} | | | | {row['truth']} | | | |"
        for row in rows
    )
    median, smaller = float(np.median(ratios)), sum(row["side"] < SIDES[0] for row in judged)
    refused = ", ".join(row["template"] for row in rows if row["wrong"] == "") or "none"
    answer = (
        f"Binary outputs of the library: all signs right in {right} of {len(judged)} templates, on pictures of "
        f"{SIDES[0]} x {SIDES[0]} in {len(judged) - smaller} of them, for {median:.2g} x the time of the default "
        "(median)."
    )
    words = _TEXT.format(
        number=len(rows), side=SIDES[0], smaller=smaller, most=_MOST_SECONDS, refused=refused,
        right=right, judged=len(judged), named=named, median=median, table=table,
        slow=sum(ratio > 2 for ratio in ratios), open_cells=sum(row["open"] for row in judged),
        open_templates=sum(row["open"] > 0 for row in judged), open_named=sum(row["open_named"] for row in judged),
    )  # fmt: skip
    return Section("library", "Signs of the library", answer, words, rows, lambda figure: _draw(figure, judged), (9, 4))


def _rows(names: list[str]) -> Iterator[dict[str, Any]]:
    for name in names:
        entry = library.load(name)
        found = row(entry, SIDES[-1])
        cost = sum(found.get(key, 0.0) for key in ("default_ms", "binary_ms")) / 1e3 / SIDES[-1] ** 2
        side = next((side for side in SIDES if cost * side**2 <= _MOST_SECONDS), SIDES[-1])
        found = found if side == SIDES[-1] else row(entry, side)
        empty = {
            "template": name,
            "side": side,
            "wrong": "",
            "named": "",
            "open": "",
            "open_named": "",
            "default_ms": "",
            "binary_ms": "",
        }
        yield empty | {"truth": ""} | found


def row(entry: LibraryEntry, side: int) -> dict[str, Any]:
    """Return what one template's signs and times are on its first worked picture, made as large as that."""
    example = large(entry.examples[0], side)
    choices = {"accuracy": "binary"}
    try:
        run_example(entry, example)  # the first runs compile
        run_example(entry, example, **choices)
        start = process_time()
        run_example(entry, example)
        middle = process_time()
        found = run_example(entry, example, **choices)
        end = process_time()
    except InputError as error:
        return {"truth": f"refused: {error}"}
    exact, truth = _exact(entry, example, found.y)
    wrong = (np.sign(exact) != np.sign(found.y)) & (np.abs(exact) > _GREY)
    open_ = _open(entry, example, exact) if wrong.any() and truth == "runs" else np.zeros(wrong.shape, bool)
    wrong &= ~open_
    unsure = np.zeros(wrong.shape, bool)
    unsure[tuple(found.undecided.T)] = True
    return {
        "wrong": int(wrong.sum()), "named": int((wrong & unsure).sum()), "open": int(open_.sum()),
        "open_named": int((open_ & unsure).sum()), "default_ms": 1e3 * (middle - start),
        "binary_ms": 1e3 * (end - middle), "truth": truth,
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
        # definitions of grey answers solve systems that are too large here; others tell the end, not a time on the way
        none = example.tolerance is not None or entry.duration != "settled"
        answer = np.empty(0) if none else ANSWERS[entry.name](Case(example.input, example.state, mask, example.bias))
        if answer.shape == like.shape and np.isfinite(answer).all():
            return answer, "definition"
    except (KeyError, ValueError, AssertionError):  # it has an answer to small pictures alone
        pass
    plan = run_example(entry, example).plan
    finer: Any = {} if plan.scheme is None or plan.cell == "discrete-time" else {"step": plan.step / 4}
    return run_example(entry, example, dtype="float64", **finer).y, "runs"


def _open(entry: LibraryEntry, example: Example, exact: Array) -> Array:
    """Return the cells whose exact sign a push of the picture by 1e-13 changes: on a mirrored one many are tied."""
    rng, found = np.random.default_rng(0), np.zeros(exact.shape, bool)
    for _ in range(_PUSHES):
        pushed = {
            name: plane + 1e-13 * rng.choice([-1.0, 1.0], plane.shape)
            for name in ("input", "state")
            if (plane := getattr(example, name)) is not None
        }
        found |= np.sign(_exact(entry, replace(example, **pushed), exact)[0]) != np.sign(exact)
    return found


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    ratios = sorted(row["binary_ms"] / row["default_ms"] for row in rows)
    axes.semilogy(ratios, np.arange(1, len(ratios) + 1) / len(ratios), drawstyle="steps-post")
    axes.set(xscale="log", yscale="linear", ylabel="share of the templates", ylim=(0, 1.02))
    axes.set_title("What the right signs cost: templates of the library")
    axes.set_xlabel('time of accuracy="binary" over that of the default')
    axes.axvline(1, color="grey", linewidth=0.8)
