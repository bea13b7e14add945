"""Compiled loops of transients and of their discrete adjoint, for any Runge-Kutta table.

A step is X_i = lim(x + g sum_j a_ij k_j), k_i = drive(X_i) - X_i, x' = lim(x + g sum_i b_i k_i). `backward` transposes
its derivative: Sandu, "On the properties of Runge-Kutta discrete adjoints", ICCS 2006. Grids are (layers, rows, cols).
"""

from typing import Any

import numpy as np

from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import copy_row, min_max
from cnnsim.learning.adjoint_terms import (
    CLIP,
    INPUT,
    STATE,
    Rule,
    add_one,
    add_terms,
    fill_planes,
    fold_planes,
    pull_terms,
    value_and_slope,
)
from cnnsim.support import Array
from cnnsim.support.compiled_loops import kept_njit


@helper
def _stages(x: Array, w: Array, u: Array, free: Array, weights: Array, rule: Rule, last: int, spare: Any) -> None:
    """Compute all stages of a step from ``x``, and the rates of the stages before number ``last``."""
    (a, _, gains), (stages, rates, planes) = rule.scheme, spare
    for s in range(len(stages)):
        stage = stages[s]
        for layer in range(len(x)):
            _after(stage[layer], x[layer], rates[:s, layer], a[s], gains[layer], free[layer], rule.limited)
        if s < last:
            fill_planes(planes, stage, u, rule)
            for layer in range(len(x)):
                for i in range(x.shape[1]):
                    _difference(rates[s, layer, i], w[layer, i], stage[layer, i])
            add_terms(rates[s], planes, weights, rule)
            for layer in range(len(x)):
                for i in range(x.shape[1]):
                    _scale(rates[s, layer, i], rates[s, layer, i], free[layer, i], x.dtype.type(1))


@helper
def _after(out: Array, x: Array, rates: Array, row: Array, gain: float, free: Array, limited: bool) -> None:
    """Write lim(x + gain sum_j row_j rates_j); held cells, where ``free`` is 0, keep x."""
    one = x.dtype.type(1)
    for i in range(len(x)):
        line, own = out[i], x[i]
        for j in range(line.size):
            line[j] = own[j]
        for s in range(len(rates)):
            if row[s] != 0:
                add_one(line, rates[s, i], gain * row[s])
        if limited:
            for j in range(line.size):
                line[j] = min_max(line[j], one) if free[i, j] else own[j]


@kept_njit(error_model="numpy", nogil=True)
def forward(path: Array, w: Array, u: Array, free: Array, weights: Array, rule: Rule, steps: int) -> None:
    """Run ``steps`` steps of n grids from ``path[:, 0]``; state s goes to ``path[:, s % kept]``."""
    count, (n, kept, layers, rows, cols) = len(rule.scheme[1]), path.shape
    for g in range(n):
        rates = np.empty((count, layers, rows, cols), path.dtype)
        stages = np.empty_like(rates)
        planes = np.empty((len(rule.channels), len(rule.around[0]), len(rule.around[1])), path.dtype)
        for s in range(steps):
            x, after = path[g, s % kept], path[g, (s + 1) % kept]
            _stages(x, w[g], u[g], free[g], weights, rule, count, (stages, rates, planes))
            for layer in range(layers):
                _after(after[layer], x[layer], rates[:, layer], rule.scheme[1], rule.scheme[2][layer], free[g, layer],
                       rule.limited)  # fmt: skip


@helper
def _difference(out: Array, a: Array, b: Array) -> None:
    for j in range(out.size):
        out[j] = a[j] - b[j]


@helper
def _stop(bar: Array, x: Array, free: Array) -> None:
    """Set the derivatives to 0 in free cells that were stopped at a limit."""
    for j in range(bar.size):
        if free[j] and abs(x[j]) >= 1:
            bar[j] = 0


@helper
def _scale(out: Array, bar: Array, free: Array, factor: float) -> None:
    for j in range(out.size):
        out[j] = factor * free[j] * bar[j]


@helper
def _add_scaled(out: Array, bar: Array, free: Array, factor: float) -> None:
    for j in range(out.size):
        out[j] += factor * free[j] * bar[j]


@helper
def _add_sloped(out: Array, bar: Array, x: Array, output: tuple[int, Array, Array]) -> None:
    """Add bar f'(x)."""
    kind, at, values = output
    if kind == CLIP:
        slope, zero, one = at[0], at.dtype.type(0), at.dtype.type(1)
        for j in range(out.size):
            out[j] += bar[j] * (slope if abs(slope * x[j]) <= one else zero)
    else:
        for j in range(out.size):
            out[j] += bar[j] * value_and_slope(kind, at, values, x[j])[1]


@kept_njit(error_model="numpy", nogil=True)
def backward(
    path: Array, w: Array, u: Array, free: Array, weights: Array, rule: Rule, steps: int,
    bars: tuple[Array, Array, Array, Array],
) -> None:  # fmt: skip
    """Pull derivatives back through the ``steps`` steps of ``path``, all of whose states are kept.

    ``bars``: the derivative by the last state, replaced by that of the first; those by w and u (n, layers, rows, cols)
    and by the weights (n, taps), which are added to.
    """
    (a, b, gains), count, (n, _, layers, rows, cols) = rule.scheme, len(rule.scheme[1]), path.shape
    r = (len(rule.around[0]) - rows) // 2
    one = path.dtype.type(1)
    for g in range(n):
        rates = np.empty((count, layers, rows, cols), path.dtype)
        stages, pulls = np.empty_like(rates), np.empty_like(rates)
        planes = np.empty((len(rule.channels), len(rule.around[0]), len(rule.around[1])), path.dtype)
        pulled, padded = np.empty_like(planes), np.zeros((layers, rows + 4 * r, cols + 4 * r), path.dtype)
        of_x, of_w, of_u, of_weights = bars[0][g], bars[1][g], bars[2][g], bars[3][g]
        for s in range(steps - 1, -1, -1):
            _stages(path[g, s], w[g], u[g], free[g], weights, rule, count - 1, (stages, rates, planes))
            for layer in range(layers):
                for i in range(rows):
                    if rule.limited:
                        _stop(of_x[layer, i], path[g, s + 1, layer, i], free[g, layer, i])
                    for q in range(count):
                        _scale(pulls[q, layer, i], of_x[layer, i], free[g, layer, i], gains[layer] * b[q])
            for q in range(count - 1, -1, -1):
                stage, pull = stages[q], pulls[q]
                fill_planes(planes, stage, u[g], rule)
                pulled[:] = 0
                for layer in range(layers):
                    for i in range(rows):
                        add_one(of_w[layer, i], pull[layer, i], one)
                        copy_row(padded[layer, 2 * r + i, 2 * r : 2 * r + cols], pull[layer, i])
                        _scale(pull[layer, i], pull[layer, i], free[g, layer, i], -one)
                pull_terms(padded, planes, pulled, weights, of_weights, rule)
                fold_planes(pulled, rows, cols, rule.around)
                bar = pull  # -k so far; k is in ``padded``
                for m in range(len(rule.channels)):
                    quantity, layer = rule.channels[m]
                    for i in range(rows):
                        line = pulled[m, r + i, r : r + cols]
                        if quantity == INPUT:
                            add_one(of_u[layer, i], line, one)
                        elif quantity == STATE:
                            add_one(bar[layer, i], line, one)
                        else:
                            _add_sloped(bar[layer, i], line, stage[layer, i], rule.output)
                for layer in range(layers):
                    for i in range(rows):
                        own, allowed = bar[layer, i], free[g, layer, i]
                        if rule.limited and q > 0:
                            _stop(own, stage[layer, i], allowed)
                        add_one(of_x[layer, i], own, one)
                        for p in range(q):
                            _add_scaled(pulls[p, layer, i], own, allowed, gains[layer] * a[q, p])
