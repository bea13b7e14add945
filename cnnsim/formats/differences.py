"""Differences of two templates, number by number."""

from collections.abc import Iterator
from itertools import zip_longest
from typing import Any

import numpy as np

from cnnsim.network import AnyTemplate, Table, Tap, Template, layered


def number_differences(ours: AnyTemplate, theirs: AnyTemplate) -> Iterator[str]:
    """Yield every number in which two templates differ; rims of zeros make no difference."""
    first, second = layered(ours).layers, layered(theirs).layers
    if len(first) != len(second):
        yield f"{len(first)} layers, not {len(second)}"
        return
    for number, (left, right) in enumerate(zip(first, second, strict=True), start=1):
        where = f"layer {number}: " if len(first) > 1 else ""
        yield from (where + text for text in _in_layer(left, right))
    if layered(ours).time_constants != layered(theirs).time_constants:
        yield f"time constants are {layered(ours).time_constants}, not {layered(theirs).time_constants}"


def _in_layer(ours: Template, theirs: Template) -> Iterator[str]:
    pairs = (("A", ours.feedback_taps, theirs.feedback_taps), ("B", ours.control_taps, theirs.control_taps))
    for matrix, ours_taps, theirs_taps in pairs:
        mine, other = _weights(ours_taps), _weights(theirs_taps)
        for k, l in sorted(mine.keys() | other.keys()):
            a, b = mine.get((k, l), 0.0), other.get((k, l), 0.0)
            if a != b:
                yield f"{matrix}({k:+d}, {l:+d}) is {a:g}, not {b:g}"
    if ours.z != theirs.z:
        yield f"z is {ours.z:g}, not {theirs.z:g}"
    if _words(ours) != _words(theirs):
        yield f"terms are {_words(ours)}, not {_words(theirs)}"
        return
    first, second = _terms(ours), _terms(theirs)
    if first != second:
        at = next(at for at, pair in enumerate(zip_longest(first, second)) if pair[0] != pair[1])
        left, right = (" ".join(map(str, side[at])) if at < len(side) else "not there" for side in (first, second))
        yield f"a term is {left}, not {right}"


def _weights(taps: tuple[Tap, ...]) -> dict[tuple[int, int], float]:
    return {(tap.k, tap.l): tap.weight for tap in taps}


def _words(template: Template) -> str:
    return "; ".join(sorted(set(map(str, template.terms)))) or "none"


def _terms(template: Template) -> list[tuple[str, str, str]]:
    """Return every tap of every term with its own function, weight included, in one order."""
    found = [
        (str(term), f"at ({k:+d}, {l:+d})", _function(term.table, weight))
        for term in template.terms
        for k, l, weight in term.taps
    ]
    return sorted(found)


def _function(table: Table | None, weight: Any) -> str:
    """Return a function with its weight as text that is the same for the same function.

    Straight lines may end in flat pieces, which say nothing: the ends are held. Which way a step is closed counts.
    """
    values = [weight] if table is None else [weight * value for value in table.values]
    if table is None or table.kind == "step":
        where = "" if table is None else f" with steps at {list(table.at)}, closed {table.closed}"
        return f"{[float(value) for value in values] if np.ndim(weight) == 0 else values}{where}"
    points = list(zip(table.at, values, strict=True))
    while len(points) > 1 and points[0][1] == points[1][1]:
        del points[0]
    while len(points) > 1 and points[-1][1] == points[-2][1]:
        del points[-1]
    return f"linear through {[(place + 0.0, value + 0.0) for place, value in points]}"
