"""Steps of a network of terms: by a Runge-Kutta scheme, or in discrete time."""

from collections import deque

import numpy as np

from cnnsim.backends.base import Check, CheckedStepper
from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.support import Array


class ReferenceTermSteps(CheckedStepper):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: ReferenceNetwork) -> None:
        plan = network.plan
        assert plan.scheme is not None
        self._network, self._scheme, self._x = network, plan.scheme, network.x
        self._limited = plan.cell == "full-range"
        self.work = network.work
        gains = [plan.scheme.gain(plan.step * rate) for rate in network.rates.ravel()]
        self._gains = np.array(gains).reshape(network.rates.shape)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        x = self._x
        rate = (self._network.drive(x, step) - x) * self._network.rates
        if self._limited:
            rate = np.where(((x >= 1) & (rate > 0)) | ((x <= -1) & (rate < 0)), 0.0, rate)
        return Check(self._network.largest(rate))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        network, scheme = self._network, self._scheme
        for number in range(step, step + count):
            network.past.append(self._x)
            rates: list[Array] = []
            for row in scheme.a:
                stage = np.where(network.free, self._after(row, rates), self._x)  # held in the stages, too
                rates.append(network.drive(stage, number, round(sum(row))) - stage)
            self._x = np.where(network.free, self._after(scheme.b, rates), self._x)

    def _after(self, weights: tuple[float, ...], rates: list[Array]) -> Array:
        x = self._x + self._gains * sum(weight * k for weight, k in zip(weights, rates, strict=True))
        return x.clip(-1, 1) if self._limited else x

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._x


class ReferenceDiscreteSteps(CheckedStepper):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: ReferenceNetwork) -> None:
        self._network, self._f = network, network.plan.characteristic
        self.work = network.work
        self._y = self._before = np.where(network.free, self._f(network.x), network.x)
        network.past = deque([self._y], maxlen=network.past.maxlen)

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        after = self._after(step)
        return Check(self._network.largest(after - self._y), repeats=step > 0 and np.array_equal(after, self._before))

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        for number in range(step, step + count):
            self._before, self._y = self._y, self._after(number)
            self._network.past.append(self._y)

    def _after(self, number: int) -> Array:
        drive = self._network.drive(self._y, number)
        after = np.where(self._network.free, self._f(drive), self._y)
        return np.where(drive == 0, self._y, after) if self._f.kind == "sign" else after

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._y
