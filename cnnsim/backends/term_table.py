"""Wiring: the terms of a network flattened to arrays of numbers, for backends that compile their loops.

A *channel* is one thing that terms look at: a quantity of a layer, some steps ago. Terms name channels by number.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cnnsim.network.layers import LayeredTemplate
from cnnsim.network.table import Table
from cnnsim.network.term import Argument, Term
from cnnsim.network.weights import reach
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support.types import Array

NOTHING = -1
IDENTITY, LINEAR, STEP, CLIP, SIGN, TANH = range(6)
"""Functions of one variable, as numbers. A step belongs to what is beyond its place, never to the place itself."""


class Channel(NamedTuple):
    """A quantity (x, y, u) of a layer, so many steps ago."""

    quantity: str
    layer: int
    ago: int


class Function(NamedTuple):
    """A function of one variable as numbers: kind, number of places, where in ``numbers`` places and values begin."""

    links: Array
    numbers: Array


class Terms(NamedTuple):
    """Terms as five arrays, one row a term or a tap.

    ``links`` (terms, 11): the layer it adds to; the channels of its neighbour and centre, and of its multiplier's (-1:
    none); its first tap and the one after its last; its function as in `Function`. ``taps`` (taps, 3): k, l, and the
    number of a plane of weights or -1; ``weight`` (taps,); ``planes`` (number, rows, cols); ``numbers``: all tables.
    """

    links: Array
    taps: Array
    weight: Array
    planes: Array
    numbers: Array


class Wiring(NamedTuple):
    """The terms of a set of channels."""

    channels: tuple[Channel, ...]
    terms: Terms
    radius: int


def kind_of(table: Table | None) -> int:
    """Return the number of a table's kind."""
    if table is None:
        return IDENTITY
    return LINEAR if table.kind == "linear" else STEP


def places_of(table: Table, dtype: np.dtype[Any]) -> list[float]:
    """Return a table's places in a precision: of one closed on the left the numbers just below, beyond which it is."""
    at = np.array(table.at, dtype)
    return np.nextafter(at, dtype.type(-np.inf)).tolist() if table.closed == "left" else at.tolist()


def characteristic(plan: Plan, dtype: np.dtype[Any]) -> Function:
    """Return the plan's output characteristic as one function."""
    shape = plan.characteristic
    kind = {"clip": CLIP, "sign": SIGN, "tanh": TANH}.get(shape.kind, kind_of(shape.table))
    if shape.table is None:
        return Function(np.array([kind, 1, 0, 0], np.int64), np.array([shape.slope], dtype))
    numbers = np.array([*places_of(shape.table, dtype), *shape.table.values], dtype)
    return Function(np.array([kind, len(shape.table.at), 0, len(shape.table.at)], np.int64), numbers)


def wire(plan: Plan, dtype: np.dtype[Any], *, static: bool) -> Wiring:
    """Return the terms of the input alone (``static``), or all others; A and B are terms as well."""
    assert plan.network is not None
    found = [
        (number, term)
        for number, layer in enumerate(plan.network.layers)
        for term in (Term(layer.B, "u_kl"), *layer.control_terms, Term(layer.A, "y_kl"), *layer.feedback_terms)
        if (term.quantities == {"u"}) == static and term.taps
    ]
    return wire_terms(plan, found, dtype)


def wire_terms(plan: Plan, found: Sequence[tuple[int, Term]], dtype: np.dtype[Any]) -> Wiring:
    """Return some terms, each with the number of the layer it adds to, as a wiring."""
    channels: dict[Channel, int] = {}

    def channel(quantity: str | None, layer: int, term: Term) -> int:
        if quantity is None:
            return NOTHING
        return channels.setdefault(Channel(quantity, layer, round(term.delay / plan.step)), len(channels))

    def pair(argument: Argument | None, number: int, term: Term) -> tuple[int, int]:
        if argument is None:
            return NOTHING, NOTHING
        other = number if term.layer is None else term.layer
        return channel(argument.neighbour, other, term), channel(argument.centre, number, term)

    links: list[list[int]] = []
    taps: list[tuple[int, int, int]] = []
    weights: list[float] = []
    planes: list[Array] = []
    numbers: list[float] = []
    for number, term in found:
        first = len(taps)
        for k, l, weight in term.taps:
            varies = np.ndim(weight) > 0
            taps.append((k, l, len(planes) if varies else NOTHING))
            weights.append(0.0 if varies else weight)
            planes += [weight] if varies else []
        at, values = (places_of(term.table, dtype), term.table.values) if term.table else ([], ())
        function = [kind_of(term.table), len(at), len(numbers), len(numbers) + len(at)]
        numbers += [*at, *values]
        channels_of_term = [*pair(term.of, number, term), *pair(term.times, number, term)]
        links.append([number, *channels_of_term, first, len(taps), *function])
    terms = Terms(
        np.array(links, np.int64).reshape(-1, 11), np.array(taps, np.int64).reshape(-1, 3), np.array(weights, dtype),
        np.array(planes, dtype).reshape(-1, *plan.shape), np.array(numbers, dtype),
    )  # fmt: skip
    return Wiring(tuple(channels), terms, reach((k, l) for k, l, _ in taps))


def longest_delay(plan: Plan, network: LayeredTemplate) -> int:
    """Return the longest delay in steps."""
    return max((round(delay / plan.step) for delay in delays_of(network)), default=0)
