"""The reference backend: plain float64 NumPy, slow and obvious. The other backends must agree with it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from cnnsim.backends import driver
from cnnsim.backends.base import Backend, Memory, Outcome, check_finite, parse_dtype
from cnnsim.backends.reference import adaptive
from cnnsim.backends.reference.drive import control
from cnnsim.backends.reference.term_steps import ReferenceDiscreteSteps, ReferenceTermSteps
from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.backends.reference.transient import ReferenceLinearSteps, closed_form
from cnnsim.network import Boundary, Characteristic, pad
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.logic import truth_table
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, InputError, Integers


class ReferenceBackend(Backend):
    """Planes are NumPy arrays, float64 for LAM and bool for LLM."""

    name = "reference"

    def __init__(self, dtype: DTypeLike | None = None) -> None:
        self.dtype = parse_dtype(np.float64 if dtype is None else dtype)
        if self.dtype != np.float64:
            raise InputError(f"the reference backend computes in float64, not in {self.dtype}")

    def load(self, values: Array, memory: Memory, *, copy: bool = True) -> Array:
        return np.array(values, dtype=np.float64) if memory == "lam" else np.asarray(values) > 0

    def read(self, plane: Array, *, copy: bool = True) -> Array:
        return plane.copy()

    def convert(self, plane: Array, memory: Memory) -> Array:
        return plane > 0 if memory == "llm" else np.where(plane, 1.0, -1.0)

    def output(self, x: Array, f: Characteristic = CLIP) -> Array:
        return f(x)

    def transient(
        self, plan: Plan, x: Array, u: Array | None, bias: Array | None = None, mask: Array | None = None
    ) -> Outcome:
        with np.errstate(over="ignore", invalid="ignore"):  # overflow is reported below
            outcome = self._run(plan, x, u, bias, mask)
        outcome = outcome._replace(x=outcome.x.reshape(x.shape))
        check_finite(outcome.x, outcome.t)
        return outcome

    @staticmethod
    def _run(plan: Plan, x: Array, u: Any, bias: Any, mask: Array | None) -> Outcome:
        if plan.method == "general":
            network = ReferenceNetwork(plan, x, u, bias, mask)
            if plan.cell == "discrete-time":
                return driver.run(plan, ReferenceDiscreteSteps(network))
            return adaptive.general(network) if plan.scheme is None else driver.run(plan, ReferenceTermSteps(network))
        w, free = control(plan, x, u, bias), np.ones(x.shape, dtype=bool) if mask is None else ~mask
        if plan.method == "closed form":
            return closed_form(plan, x, w, free)
        if plan.method == "adaptive":
            return adaptive.linear(plan, x, w, free)
        return driver.run(plan, ReferenceLinearSteps(plan, x, w, free))

    def cellwise(self, operation: Cellwise, planes: Sequence[Array], parameters: Sequence[float]) -> tuple[Array, ...]:
        return operation.array(*planes, *parameters)

    def logic(self, function: int, p: Array, q: Array) -> Array:
        return truth_table(function)[2 * p.astype(int) + q.astype(int)]

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: Array) -> Array:
        r, (rows, cols) = rule.radius, plane.shape[-2:]
        around = pad(plane, r, boundary, boundary.u > 0)
        seen = [around[..., r + k : r + k + rows, r + l : r + l + cols] != negated for k, l, negated in rule.literals]
        combine = np.logical_and if rule.conjunction else np.logical_or
        return combine.reduce(seen) if seen else np.full(plane.shape, rule.conjunction)

    def count(self, plane: Array) -> int | Integers:
        black = np.count_nonzero(plane, axis=(-2, -1))
        return black if plane.ndim == 3 else int(black)


BACKEND = ReferenceBackend
