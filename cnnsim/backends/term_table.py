"""Terms of a network as tables of numbers with named columns, for backends that compile their loops.

A *channel* is an argument of terms: a quantity of a layer, some steps ago. Terms name channels by number.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.codes import NOTHING, FunctionCode
from cnnsim.network import Argument, LayeredTemplate, Table, Term, reach
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import Array


class Channel(NamedTuple):
    """A quantity (x, y, u) of a layer, ``ago`` steps before the present one."""

    quantity: str
    layer: int
    ago: int


class Function(NamedTuple):
    """A function of one variable: its kind, its number of places, where they and the values begin in ``numbers``."""

    kind: int
    places: int
    at: int
    values: int
    numbers: Array


class TermColumns(NamedTuple):
    """One entry a term: the ``layer`` it adds to; the channels of its ``neighbour`` and ``centre``, and of its
    multiplier's (NOTHING: none); its taps ``first_tap`` .. ``end_tap`` - 1; its `Function` without the numbers.
    """

    layer: Array
    neighbour: Array
    centre: Array
    times_neighbour: Array
    times_centre: Array
    first_tap: Array
    end_tap: Array
    kind: Array
    places: Array
    at: Array
    values: Array


class TapColumns(NamedTuple):
    """One entry a tap: its offset, its weight, or the number of its plane of weights (else NOTHING)."""

    k: Array
    l: Array
    plane: Array
    weight: Array


class TermTable(NamedTuple):
    """Some terms of a network: ``planes`` (number, rows, cols) are weights that differ from cell to cell, ``numbers``
    the places and values of all tables, ``radius`` the largest offset of the taps.
    """

    channels: tuple[Channel, ...]
    terms: TermColumns
    taps: TapColumns
    planes: Array
    numbers: Array
    radius: int


def kind_of(table: Table | None) -> int:
    """Return the code of a table's kind."""
    if table is None:
        return FunctionCode.IDENTITY
    return FunctionCode.LINEAR if table.kind == "linear" else FunctionCode.STEP


def places_of(table: Table, dtype: np.dtype[Any]) -> list[float]:
    """Return a table's places in a dtype; if the table is closed on the left, the next smaller numbers.

    v >= place is then the same as v > the number returned, as for a table closed on the right.
    """
    at = np.array(table.at, dtype)
    return np.nextafter(at, dtype.type(-np.inf)).tolist() if table.closed == "left" else at.tolist()


def without_flat_ends(table: Table) -> Table:
    """Return the same function without places at the ends of a linear table between which it is constant."""
    at, values = list(table.at), list(table.values)
    if table.kind == "linear":
        while len(at) > 1 and values[0] == values[1]:
            del at[0], values[0]
        while len(at) > 1 and values[-1] == values[-2]:
            del at[-1], values[-1]
    return Table(table.kind, tuple(at), tuple(values), table.closed)


def characteristic(plan: Plan, dtype: np.dtype[Any]) -> Function:
    """Return the plan's output characteristic as one function."""
    f = plan.characteristic
    if f.table is None:
        kind = {"clip": FunctionCode.CLIP, "sign": FunctionCode.SIGN, "tanh": FunctionCode.TANH}[f.kind]
        return Function(kind, 1, 0, 0, np.array([f.slope], dtype))
    numbers = np.array([*places_of(f.table, dtype), *f.table.values], dtype)
    return Function(kind_of(f.table), len(f.table.at), 0, len(f.table.at), numbers)


def table_of(plan: Plan, dtype: np.dtype[Any], *, static: bool) -> TermTable:
    """Return the terms of the input alone (``static``), or all others; A and B are terms as well."""
    assert plan.network is not None
    found = [
        (number, term)
        for number, layer in enumerate(plan.network.layers)
        for term in (Term(layer.B, "u_kl"), *layer.control_terms, Term(layer.A, "y_kl"), *layer.feedback_terms)
        if (term.quantities == {"u"}) == static and term.taps
    ]
    return tabulate(plan, found, dtype)


def tabulate(plan: Plan, found: Sequence[tuple[int, Term]], dtype: np.dtype[Any]) -> TermTable:
    """Return some terms, each with the number of the layer it adds to, as a table."""
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

    rows: list[tuple[int, ...]] = []
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
        table = without_flat_ends(term.table) if term.table else None
        at, values = (places_of(table, dtype), table.values) if table else ([], ())
        function = kind_of(term.table), len(at), len(numbers), len(numbers) + len(at)
        numbers += [*at, *values]
        channels_of_term = *pair(term.of, number, term), *pair(term.times, number, term)
        rows.append((number, *channels_of_term, first, len(taps), *function))
    terms = TermColumns(*np.array(rows, np.int64).reshape(-1, len(TermColumns._fields)).T.copy())
    columns = list(np.array(taps, np.int64).reshape(-1, 3).T.copy())
    return TermTable(
        tuple(channels),
        terms,
        TapColumns(columns[0], columns[1], columns[2], np.array(weights, dtype)),
        np.array(planes, dtype).reshape(-1, *plan.shape),
        np.array(numbers, dtype),
        reach((tap[0], tap[1]) for tap in taps),
    )


def longest_delay(plan: Plan, network: LayeredTemplate) -> int:
    """Return the longest delay in steps."""
    return max((round(delay / plan.step) for delay in delays_of(network)), default=0)
