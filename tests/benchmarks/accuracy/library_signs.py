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
_MOST_SECONDS = 1.0
"""That the default and binary runs of a template may take together, by what they take at the smallest side."""
_PUSHES = 6
"""Of a picture whose exact signs are in doubt."""
_SLOW = 2.0
"""Times the default, beyond which the page says what was done."""
_ROUNDS, _LONG = 3, 0.1
"""Rounds of which the best time is taken, but for runs of more seconds than that."""
_GREY = 0.02
"""Outputs of grey answers nearer to 0 than this are not told apart by their sign."""

_TEXT = """\
Each of the {number} templates on its first worked picture, mirrored at its edges until it fills {side} x {side} cells
({smaller} of them fewer, which the table says: both runs together are given {most:g} s). The exact signs are the
definition's (`tests/oracles`), which knows nothing of states and steps; where it has no answer on such a picture, or
the time is a part of the template, they are those of a run by a quarter of the step in float64 (it says "runs").
Times are of the processor, of the default and of `accuracy="binary"`.

{right} of {judged} templates have all signs right; {tied} more are right but for cells that are tied: their exact sign
changes if the picture is pushed by 1e-13, or with half the step of the run that tells it. They have {tied_cells} such
cells that differ, of which the run names {tied_named}. Wrong elsewhere: {wrong}. Not judged: {refused}.

Median time against the default: {median:.2g} x. {slow} take more than twice as long:

{slow_ones}

| template | side | signs | named | truth | default [ms] | binary [ms] | ratio |
|---|---|---|---|---|---|---|---|
{table}"""


def section() -> Section:
    """Measure all templates of the library."""
    names = library.names()
    rows = list(watched(_rows(names), "signs of the library", len(names)))
    judged = [row for row in rows if row["wrong"] != ""]
    right = [row for row in judged if not row["wrong"] + row["tied"]]
    tied = [row for row in judged if row["tied"] and not row["wrong"]]
    wrong = ", ".join(f"{row['template']} ({verdict(row)})" for row in judged if row["wrong"]) or "none"
    table = "\n".join(
        f"| {row['template']} | {row['side']} | {verdict(row)} | {row['undecided']} | {row['truth']} | "
        f"{row['default_ms']:.3g} | {row['binary_ms']:.3g} | {_ratio(row):.2g} |"
        if row["wrong"] != ""
        else f"| {row['template']} | {row['side']} | | | {row['truth']} | | | |"
        for row in rows
    )
    slow = sorted((row for row in judged if _ratio(row) > _SLOW), key=_ratio, reverse=True)
    slow_ones = "\n".join(f"- {row['template']}, {_ratio(row):.2g} x: {row['how']}" for row in slow)
    median, smaller = float(np.median([_ratio(row) for row in judged])), sum(row["side"] < SIDES[0] for row in judged)
    refused = ", ".join(row["template"] for row in rows if row["wrong"] == "") or "none"
    answer = (
        f"Binary outputs of the library: all signs right in {len(right)} of {len(judged)} templates, in {len(tied)} "
        f"more but for cells that are tied, on pictures of {SIDES[0]} x {SIDES[0]} in {len(judged) - smaller} of "
        f"them, for {median:.2g} x the time of the default (median)."
    )
    words = _TEXT.format(
        number=len(rows), side=SIDES[0], smaller=smaller, most=_MOST_SECONDS, refused=refused, wrong=wrong,
        right=len(right), judged=len(judged), tied=len(tied), median=median, table=table, slow=len(slow),
        slow_ones=slow_ones or "none", tied_cells=sum(row["tied"] for row in judged),
        tied_named=sum(row["tied_named"] for row in judged),
    )  # fmt: skip
    return Section("library", "Signs of the library", answer, words, rows, lambda figure: _draw(figure, judged), (9, 4))


def verdict(row: dict[str, Any]) -> str:
    """Say which signs are right."""
    tied = f"{row['tied']} tied, {_of(row['tied_named'], row['tied'])} named"
    if row["wrong"]:
        named = f"{row['wrong']} wrong, {_of(row['named'], row['wrong'])} named"
        return f"{named}; {tied}" if row["tied"] else named
    return f"right but for {tied}" if row["tied"] else "right"


def _of(some: int, number: int) -> str:
    return "all" if some == number else str(some)


def _ratio(row: dict[str, Any]) -> float:
    return float(row["binary_ms"] / row["default_ms"])


def _rows(names: list[str]) -> Iterator[dict[str, Any]]:
    for name in names:
        entry = library.load(name)
        found = row(entry, SIDES[-1])
        cost = sum(found.get(key, 0.0) for key in ("default_ms", "binary_ms")) / 1e3 / SIDES[-1] ** 2
        side = next((side for side in SIDES if cost * side**2 <= _MOST_SECONDS), SIDES[-1])
        found = found if side == SIDES[-1] else row(entry, side)
        empty = dict.fromkeys(
            ("wrong", "named", "tied", "tied_named", "undecided", "default_ms", "binary_ms", "how"), ""
        )
        yield {"template": name, "side": side} | empty | {"truth": ""} | found


def row(entry: LibraryEntry, side: int) -> dict[str, Any]:
    """Return what one template's signs and times are on its first worked picture, made as large as that."""
    example = large(entry.examples[0], side)
    choices = {"accuracy": "binary"}
    try:
        run_example(entry, example)  # the first runs compile
        run_example(entry, example, **choices)
        times = []
        for _ in range(_ROUNDS):
            start = process_time()
            run_example(entry, example)
            middle = process_time()
            found = run_example(entry, example, **choices)
            times.append((middle - start, process_time() - middle))
            if sum(times[0]) > _LONG:
                break
    except InputError as error:
        return {"truth": f"refused: {error}"}
    exact, truth = _exact(entry, example, found.y)
    differs = (np.sign(exact) != np.sign(found.y)) & (np.abs(exact) > _GREY)
    open_ = _open(entry, example, exact) if differs.any() and truth == "runs" else np.zeros(differs.shape, bool)
    unsure = np.zeros(differs.shape, bool)
    unsure[tuple(found.undecided.T)] = True
    wrong, tied = differs & ~open_, differs & open_
    default, binary = (1e3 * min(way) for way in zip(*times, strict=True))
    return {
        "wrong": int(wrong.sum()), "named": int((wrong & unsure).sum()), "tied": int(tied.sum()),
        "tied_named": int((tied & unsure).sum()), "undecided": int(unsure.sum()), "default_ms": default,
        "binary_ms": binary, "truth": truth, "how": str(found.how).split(": ", 1)[1],
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
    return _by_runs(entry, example, 4), "runs"


def _by_runs(entry: LibraryEntry, example: Example, finer: int) -> Array:
    plan = run_example(entry, example).plan
    steps: Any = {} if plan.scheme is None or plan.cell == "discrete-time" else {"step": plan.step / finer}
    return run_example(entry, example, dtype="float64", **steps).y


def _open(entry: LibraryEntry, example: Example, exact: Array) -> Array:
    """Return the cells whose exact sign nobody knows: a push of the picture by 1e-13, or half the step, changes it.

    On a mirrored picture many are tied.
    """
    rng, found = np.random.default_rng(0), np.sign(_by_runs(entry, example, 8)) != np.sign(exact)
    for _ in range(_PUSHES):
        pushed = {
            name: plane + 1e-13 * rng.choice([-1.0, 1.0], plane.shape)
            for name in ("input", "state")
            if (plane := getattr(example, name)) is not None
        }
        found |= np.sign(_by_runs(entry, replace(example, **pushed), 4)) != np.sign(exact)
    return found


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    ratios = sorted(_ratio(row) for row in rows)
    axes.semilogy(ratios, np.arange(1, len(ratios) + 1) / len(ratios), drawstyle="steps-post")
    axes.set(xscale="log", yscale="linear", ylabel="share of the templates", ylim=(0, 1.02))
    axes.set_title("What the right signs cost: templates of the library")
    axes.set_xlabel('time of accuracy="binary" over that of the default')
    axes.axvline(1, color="grey", linewidth=0.8)
