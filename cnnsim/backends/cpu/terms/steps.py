"""Steps of a network of terms: by a Runge-Kutta scheme of any stages, or in discrete time."""

import numpy as np

from cnnsim.backends.base import Check, Stepper
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.cpu.terms.network import CompiledNetwork
from cnnsim.support import Array, Flags

STRIP = 1 << 14
"""Cells whose outputs are computed at a time: what NumPy keeps in between stays in the cache."""


class CompiledTermSteps(Stepper):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: CompiledNetwork) -> None:
        assert network.plan.scheme is not None
        self._network, self._done = network, 0
        self.work = network.work * len(network.plan.scheme.b)

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        largest = self._network.do(TaskCode.CHECK, step, 1)[:-1]
        return Check(float((largest * self._network.rates.astype(largest.dtype)).max()))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        self._network.do(TaskCode.STEP, step, count)
        self._done = step + count

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._done)


class CompiledDiscreteSteps(Stepper):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: CompiledNetwork, held: Flags | None) -> None:
        self._network, self.work, self._checked, self._done = network, network.work, False, 0
        x, y = network.start, network.states[0]
        cols = x.shape[-1]
        lines, first, many = x.reshape(-1, cols), y.reshape(-1, cols), max(1, STRIP // cols)
        for i in range(0, len(lines), many):
            first[i : i + many] = network.plan.characteristic(lines[i : i + many])
        if held is not None:
            np.copyto(first, lines, where=held.reshape(first.shape))
        network.start = y  # of no output before it is another one known

    def start_span(self, step: int) -> None:
        """See `Stepper.start_span`."""
        self._network.start_span(step)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        *largest, other = self._network.do(TaskCode.DISCRETE, step, 1)
        self._checked = True
        return Check(float(max(largest)), repeats=step > 0 and not other)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        begin = step + self._checked  # the outputs of a step that was checked are there
        if begin < step + count:
            self._network.do(TaskCode.DISCRETE, begin, step + count - begin)
        self._checked, self._done = False, step + count

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._done)
