"""Compiled terms of the adjoint transient: padded planes, weighted sums over neighbourhoods, and their transposes."""

import math
from typing import Any, NamedTuple

from cnnsim.backends.codes import NOTHING, FunctionCode
from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import min_max
from cnnsim.support import Array
from cnnsim.support.compiled_loops import kept_helper

IDENTITY, LINEAR, _, CLIP, _, TANH = map(int, FunctionCode)
STATE, OUTPUT, INPUT = range(3)


class Rule(NamedTuple):
    """The equation of a network in numbers of one dtype.

    ``channels`` (m, 2): quantity (STATE, OUTPUT, INPUT) and layer; ``terms``, ``taps``: records of
    `term_table.TermColumns` and of offsets; ``numbers``: places and values of tables; ``around``: the real row and
    column of each padded one, -1 for a constant; ``constants``: output and input of virtual cells; ``output``: kind,
    places and values of y = f(x); ``scheme``: a (stages, stages), b (stages,), gains (layers,); ``limited``: |x| <= 1.
    """

    channels: Array
    terms: Array
    taps: Array
    numbers: Array
    around: tuple[Array, Array]
    constants: tuple[Any, Any]
    output: tuple[int, Array, Array]
    scheme: tuple[Array, Array, Array]
    limited: bool


_summed = kept_helper(error_model="numpy", forceinline=True, fastmath={"reassoc", "contract"})
"""Compiles a helper whose sums may be added in any order and with fused products, so that they become vector code."""


@helper
def value_and_slope(kind: int, at: Array, values: Array, v: float) -> Any:
    """Return f(v) and f'(v); at a kink of clip the slope is that of the inner side, at a place that of the left one."""
    zero, one = at.dtype.type(0), at.dtype.type(1)
    if kind == IDENTITY:
        return v, one
    if kind == CLIP:
        p = at[0] * v
        return (one, zero) if p > one else (-one, zero) if p < -one else (p, at[0])
    if kind == TANH:
        y = at.dtype.type(math.tanh(at[0] * v))
        return y, at[0] * (one - y * y)
    if kind == LINEAR:
        if v <= at[0]:
            return values[0], zero
        for s in range(at.size - 1):
            if v <= at[s + 1]:
                rise = (values[s + 1] - values[s]) / (at[s + 1] - at[s])
                return values[s] + rise * (v - at[s]), rise
        return values[at.size - 1], zero
    s = 0
    while s < at.size and v > at[s]:
        s += 1
    return values[s], zero


@helper
def fill_planes(planes: Array, x: Array, u: Array, rule: Rule) -> None:
    """Write the channels of a state with their virtual cells into ``planes`` (m, rows + 2 r, cols + 2 r)."""
    channels, (row_of, col_of), constants, (kind, at, values) = rule.channels, rule.around, rule.constants, rule.output
    rows, cols = x.shape[1:]
    r = (planes.shape[1] - rows) // 2
    for m in range(len(channels)):
        quantity, layer = channels[m]
        source = u[layer] if quantity == INPUT else x[layer]
        constant = constants[1] if quantity == INPUT else constants[0]
        for i in range(rows):
            line, own = planes[m, i + r, r : r + cols], source[i]
            if quantity != OUTPUT:
                for j in range(cols):
                    line[j] = own[j]
            elif kind == CLIP:
                for j in range(cols):
                    line[j] = min_max(own[j] * at[0], x.dtype.type(1))
            else:
                for j in range(cols):
                    line[j] = value_and_slope(kind, at, values, own[j])[0]
        for i in range(rows + 2 * r):
            inner = r <= i < r + rows
            for c in range(2 * r if inner else cols + 2 * r):
                j = c + cols if inner and c >= r else c
                p, q = row_of[i], col_of[j]
                planes[m, i, j] = constant if p < 0 or q < 0 else planes[m, r + p, r + q]


@helper
def fold_planes(planes: Array, rows: int, cols: int, around: tuple[Array, Array]) -> None:
    """Add the values of virtual cells to the real cells that they repeat: the transpose of `fill_planes`."""
    r = (planes.shape[1] - rows) // 2
    for m in range(len(planes)):
        for i in range(rows + 2 * r):
            inner = r <= i < r + rows
            for c in range(2 * r if inner else cols + 2 * r):
                j = c + cols if inner and c >= r else c
                p, q = around[0][i], around[1][j]
                if p >= 0 and q >= 0:
                    planes[m, r + p, r + q] += planes[m, i, j]


@_summed
def _add_three(out: Array, line: Array, w0: float, w1: float, w2: float) -> None:
    for j in range(out.size):
        out[j] += w0 * line[j] + w1 * line[j + 1] + w2 * line[j + 2]


@_summed
def add_one(out: Array, line: Array, w: float) -> None:
    """Add w line to a row."""
    for j in range(out.size):
        out[j] += w * line[j]


@_summed
def _dot(a: Array, b: Array) -> float:
    total = a.dtype.type(0)
    for j in range(a.size):
        total += a[j] * b[j]
    return total


@_summed
def _dot_three(a: Array, b: Array) -> Any:
    first = second = third = a.dtype.type(0)
    for j in range(a.size):
        first += a[j] * b[j]
        second += a[j] * b[j + 1]
        third += a[j] * b[j + 2]
    return first, second, third


@helper
def _is_linear(term: Any) -> bool:
    return term["centre"] == NOTHING and term["times_neighbour"] == NOTHING and term["kind"] == IDENTITY


@helper
def _factors(term: Any, planes: Array, i: int, j: int, k: int, l: int, numbers: Array) -> Any:
    """Return f(v), f'(v) and m of a term for the neighbour (i + k, j + l) of a cell (i, j) of the padded planes."""
    v = planes[term["neighbour"], i + k, j + l]
    if term["centre"] != NOTHING:
        v -= planes[term["centre"], i, j]
    at = numbers[term["at"] : term["at"] + term["places"]]
    f, slope = value_and_slope(term["kind"], at, numbers[term["values"] :], v)
    if term["times_neighbour"] == NOTHING:
        return f, slope, numbers.dtype.type(1)
    m = planes[term["times_neighbour"], i + k, j + l]
    if term["times_centre"] != NOTHING:
        m -= planes[term["times_centre"], i, j]
    return f, slope, m


@helper
def add_terms(total: Array, planes: Array, weights: Array, rule: Rule) -> None:
    """Add the terms to the drive (layers, rows, cols)."""
    rows, cols = total.shape[1:]
    r = (planes.shape[1] - rows) // 2
    for t in range(len(rule.terms)):
        term = rule.terms[t]
        plane, own, linear = planes[term["neighbour"]], total[term["layer"]], _is_linear(term)
        first, end = term["first_tap"], term["end_tap"]
        for i in range(rows):
            out, e = own[i], first
            while e < end:
                k, l = rule.taps[e]["k"], rule.taps[e]["l"]
                if not linear:
                    for j in range(cols):
                        f, _, m = _factors(term, planes, r + i, r + j, k, l, rule.numbers)
                        out[j] += weights[e] * f * m
                elif e + 2 < end and rule.taps[e + 2]["k"] == k:
                    line = plane[r + i + k, r + l : r + l + cols + 2]
                    _add_three(out, line, weights[e], weights[e + 1], weights[e + 2])
                    e += 2
                else:
                    add_one(out, plane[r + i + k, r + l : r + l + cols], weights[e])
                e += 1


@helper
def pull_terms(bar: Array, planes: Array, pulled: Array, weights: Array, into: Array, rule: Rule) -> None:
    """Transpose `add_terms`: add to ``pulled``, as ``planes``, and to ``into``, as ``weights``.

    ``bar`` (layers, rows + 4 r, cols + 4 r) is the derivative by the drive, with zeros around it.
    """
    r = (bar.shape[1] - planes.shape[1]) // 2
    for t in range(len(rule.terms)):
        term = rule.terms[t]
        if _is_linear(term):
            _pull_linear(bar[term["layer"]], planes[term["neighbour"]], pulled[term["neighbour"]], weights, into,
                         (term["first_tap"], term["end_tap"], r), rule.taps)  # fmt: skip
        else:
            _pull_function(bar[term["layer"]], planes, pulled, weights, into, term, (rule.taps, rule.numbers, r))


@helper
def _pull_linear(
    bar: Array, plane: Array, pulled: Array, weights: Array, into: Array, part: tuple[int, int, int], taps: Array
) -> None:
    first, end, r = part
    rows, cols = plane.shape[0] - 2 * r, plane.shape[1] - 2 * r
    for i in range(rows + 2 * r):
        out, own, e = pulled[i], bar[r + i, 2 * r : 2 * r + cols], first
        while e < end:
            k, l = taps[e]["k"], taps[e]["l"]
            seen, back = plane[i + k], bar[r + i - k]
            three = e + 2 < end and taps[e + 2]["k"] == k
            if three:
                _add_three(out, back[r - l - 2 :], weights[e + 2], weights[e + 1], weights[e])
            else:
                add_one(out, back[r - l :], weights[e])
            if r <= i < r + rows:
                if three:
                    sums = _dot_three(own, seen[r + l : r + l + cols + 2])
                    into[e] += sums[0]
                    into[e + 1] += sums[1]
                    into[e + 2] += sums[2]
                else:
                    into[e] += _dot(own, seen[r + l : r + l + cols])
            e += 3 if three else 1


@helper
def _pull_function(
    bar: Array, planes: Array, pulled: Array, weights: Array, into: Array, term: Any, given: tuple[Array, Array, int]
) -> None:
    taps, numbers, r = given
    for i in range(r, planes.shape[1] - r):
        for j in range(r, planes.shape[2] - r):
            own = bar[r + i, r + j]
            for e in range(term["first_tap"], term["end_tap"]):
                k, l = taps[e]["k"], taps[e]["l"]
                f, slope, m = _factors(term, planes, i, j, k, l, numbers)
                into[e] += own * f * m
                to_v, to_m = own * weights[e] * slope * m, own * weights[e] * f
                pulled[term["neighbour"], i + k, j + l] += to_v
                if term["centre"] != NOTHING:
                    pulled[term["centre"], i, j] -= to_v
                if term["times_neighbour"] != NOTHING:
                    pulled[term["times_neighbour"], i + k, j + l] += to_m
                if term["times_centre"] != NOTHING:
                    pulled[term["times_centre"], i, j] -= to_m
