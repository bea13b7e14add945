"""In which numbers two templates differ."""

from collections.abc import Iterator

from cnnsim.layers import AnyTemplate, layered
from cnnsim.table import Table
from cnnsim.template import Tap, Template


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
    for matrix, first, second in pairs:
        left, right = _weights(first), _weights(second)
        for k, l in sorted(left.keys() | right.keys()):
            a, b = left.get((k, l), 0.0), right.get((k, l), 0.0)
            if a != b:
                yield f"{matrix}({k:+d}, {l:+d}) is {a:g}, not {b:g}"
    if ours.z != theirs.z:
        yield f"z is {ours.z:g}, not {theirs.z:g}"
    if _terms(ours) != _terms(theirs):
        yield f"terms are {_words(ours)}, not {_words(theirs)}" if _words(ours) != _words(theirs) else "terms differ"


def _weights(taps: tuple[Tap, ...]) -> dict[tuple[int, int], float]:
    return {(tap.k, tap.l): tap.weight for tap in taps}


def _words(template: Template) -> str:
    return "; ".join(sorted(map(str, template.terms))) or "none"


def _terms(template: Template) -> list[tuple[object, ...]]:
    """Return every tap of every term with its own function, weight included, in one order."""
    found = [(str(term), k, l, _scaled(term.table, weight)) for term in template.terms for k, l, weight in term.taps]
    return sorted(found, key=repr)


def _scaled(table: Table | None, weight: object) -> object:
    """Return a function with its weight as plain numbers; which way a step is closed says nothing of straight lines."""
    if table is None or not isinstance(weight, float):
        return repr(weight), repr(table)
    return table.kind, table.at, tuple(weight * value for value in table.values), table.kind == "linear" or table.closed
