"""Steps of a network of terms: by a Runge-Kutta scheme of any stages, or in discrete time."""

import numpy as np
from numba import prange

from cnnsim.backends.base import Check, Stepper
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.backends.cpu.term_loops import CHECK, DISCRETE, EULER, RATE, Cells
from cnnsim.backends.cpu.terms import CompiledNetwork
from cnnsim.support import Array


@twins
def combine(out: Array, x: Array, rates: Array, weights: Array, cells: Cells) -> None:
    """Write x + gain of its layer * sum of weight * rate; cells that a mask holds keep x."""
    gains, mask, limited = cells
    n, layers, height, width = x.shape
    one = x.dtype.type(1)
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        to, row = out[g, layer, i], x[g, layer, i]
        for j in range(width):
            v = row[j]
            if not (mask.size and mask[g, layer, i, j]):
                total = x.dtype.type(0)
                for s in range(weights.size):
                    total += weights[s] * rates[s, g, layer, i, j]
                v += gains[layer] * total
                if limited:
                    v = one if v > one else -one if v < -one else v
            to[j] = v


class CompiledTermSteps(Stepper):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: CompiledNetwork) -> None:
        scheme, dtype = network.plan.scheme, network.dtype
        assert scheme is not None
        self._network, self._x = network, network.x.copy()
        self.work = network.work * len(scheme.b)
        self._a, self._b = [np.array(row, dtype) for row in scheme.a], np.array(scheme.b, dtype)
        self._ahead = [round(sum(row)) for row in scheme.a]
        stages = len(scheme.b) if len(scheme.b) > 1 else 0  # Euler needs none
        self._stage, self._rates = (
            np.empty((min(stages, 1), *network.shape), dtype),
            np.empty((stages, *network.shape), dtype),
        )
        self._combine = combine.for_work(self._x.size)

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        network, x = self._network, self._x
        network.advance((x, network.largest, x, network.w, network.past), (CHECK, step, 1, 0, network.lines))
        n, layers, rows, _ = network.shape
        of_layers = network.largest.reshape(n, rows, layers).max((0, 1))  # the order of `run_rows`
        return Check(float((of_layers * network.rates.astype(network.dtype)).max()))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        network, x, rates = self._network, self._x, self._rates
        if len(self._b) == 1:
            network.advance((x, network.largest, x, network.w, network.past), (EULER, step, count, 0, network.lines))
            return
        for number in range(step, step + count):
            network.keep(number, x)
            for s, (row, ahead) in enumerate(zip(self._a, self._ahead, strict=True)):
                self._combine(self._stage[0], x, rates, row, network.cells)
                planes = rates[s], network.largest, self._stage[0], network.w, network.past
                network.advance(planes, (RATE, number + ahead, 1, 0, network.lines))
            self._combine(x, x, rates, self._b, network.cells)

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._x)


class CompiledDiscreteSteps(Stepper):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: CompiledNetwork) -> None:
        self._network, self.work = network, network.work
        y = network.plan.characteristic(network.x)
        self._y = np.where(network.mask, network.x, y) if network.mask.size else y
        self._before, self._after, self._checked = np.empty_like(y), np.empty_like(y), False
        network.past[:] = self._y

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        self._take(step)
        self._checked = True
        repeats = step > 0 and np.array_equal(self._after, self._before)
        return Check(float(self._network.largest.max()), repeats=repeats)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        for number in range(step, step + count):
            if not self._checked:
                self._take(number)
            self._before, self._y, self._after = self._y, self._after, self._before
            self._checked = False

    def _take(self, number: int) -> None:
        network = self._network
        network.keep(number, self._y)
        planes = self._after, network.largest, self._y, network.w, network.past
        network.advance(planes, (DISCRETE, number, 1, 0, network.lines))

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._y)
