"""Random transients with exact answers: stable templates, pictures, boundaries, times; what an accuracy keeps of it."""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from time import process_time
from typing import Any

import numpy as np

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed, run_transient
from cnnsim.backends import get
from cnnsim.backends.base import Backend
from cnnsim.backends.reference.drive import control
from cnnsim.support import Floats
from cnnsim.task import make_task
from tests.oracles.exact_transient import exact

SCHEMES = ("euler", "heun", "rk4")
STEPS = tuple(0.8 * 0.5**k for k in range(15))
ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)


@dataclass(frozen=True)
class Case:
    """What `run_transient` takes, and the exact state at the end."""

    given: dict[str, Any]
    exact: Floats


@lru_cache
def case(seed: int) -> Case:
    """A random transient: symmetric, cooperative, diffusive or any template, a picture, an input, a time."""
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(2, 14, 2))
    kind = rng.integers(4)
    A = rng.normal(size=(3, 3))
    A = A + A[::-1, ::-1] if kind in (0, 2) else A
    A = np.abs(A) if kind in (1, 2) else A
    A *= rng.uniform(0.5, 4 if kind else 3) / np.abs(A).sum()
    A[1, 1] += 0 if kind == 2 else rng.integers(3)
    x = np.where(rng.random(shape) < 0.5, 1.0, -1.0) if rng.random() < 0.3 else rng.uniform(-1, 1, shape)
    boundary = [ZERO_FLUX, PERIODIC, fixed(0.0), fixed(-1.0)][rng.integers(4)]
    B = rng.normal(size=(3, 3)) * rng.choice([0.0, 0.3])
    template = Template(A, B, float(rng.normal() * 0.5), f"random {seed}")
    bias = rng.normal(size=shape) * 0.3
    duration = float(np.round(rng.uniform(0.5, 12.0), 2))
    given: dict[str, Any] = {
        "template": template, "state": x, "input": x[::-1], "bias": bias, "boundary": boundary, "duration": duration,
    }  # fmt: skip
    drive = control(make_task(**given).plan, x, given["input"], bias)
    return Case(given, exact(A, drive, x, boundary, duration))


class Counting:
    """A backend that counts how often A*y is evaluated."""

    def __init__(self, backend: Backend) -> None:
        self._backend, self.evaluations = backend, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._backend, name)

    def transient(self, plan: Any, *planes: Any) -> Any:
        self.evaluations += plan.steps * (len(plan.scheme.b) if plan.scheme else 1)
        return self._backend.transient(plan, *planes)


Setting = tuple[int, str, float]
"""Evaluations, scheme and step."""


def by_hand(one: Case, least: float = min(ACCURACIES)) -> dict[float, Setting]:
    """The setting of fewest evaluations that keeps each accuracy, of all schemes and steps tried; in float64.

    Steps are tried from the longest on until one keeps ``least``: shorter ones only cost more.
    """
    best: dict[float, Setting] = {}
    for scheme in SCHEMES:
        for step in STEPS:
            where: Any = Counting(get("cpu", "float64"))
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", RuntimeWarning)  # that a step may be unstable
                    found = run_transient(**one.given, scheme=scheme, step=step, backend=where)
            except InputError:  # not stable
                continue
            error = float(np.abs(found.x - one.exact).max())
            for accuracy in ACCURACIES:
                if error <= accuracy:
                    setting = where.evaluations, scheme, step
                    best[accuracy] = min(best.get(accuracy, setting), setting)
            if error <= least or where.evaluations > max((best[a][0] for a in best if a <= least), default=10**9):
                break
    return best


def _times(one: Case, accuracy: float, hand: Setting) -> float:
    """Return the processor's time of a run to an accuracy over that of the setting found by hand: of the best of 5."""
    where, best = get("cpu", "float64", threads=1), [np.inf, np.inf]
    for _ in range(5):
        start = process_time()
        run_transient(**one.given, accuracy=accuracy, backend=where)
        middle = process_time()
        run_transient(**one.given, scheme=hand[1], step=hand[2], backend=where)
        best = [min(best[0], middle - start), min(best[1], process_time() - middle)]
    return best[0] / best[1]


def kept(seeds: range, *, hand: bool = False) -> Iterator[dict[str, Any]]:
    """Yield, for each case and accuracy, the error, what the run said of it, and the evaluations."""
    for seed in seeds:
        one = case(seed)
        fewest = by_hand(one) if hand else {}
        for accuracy in ACCURACIES:
            where: Any = Counting(get("cpu", "float64"))
            found = run_transient(**one.given, accuracy=accuracy, backend=where)
            yield {
                "seed": seed, "accuracy": accuracy, "error": float(np.abs(found.x - one.exact).max()),
                "estimate": found.error, "evaluations": where.evaluations,
                "by hand": fewest[accuracy][0] if accuracy in fewest else None,
                "times": _times(one, accuracy, fewest[accuracy]) if accuracy in fewest else None, "how": found.how,
            }  # fmt: skip
        signs = run_transient(**one.given, accuracy="binary")
        wrong = np.argwhere(np.sign(signs.y) != np.sign(one.exact))
        named = {tuple(cell) for cell in signs.undecided}
        yield {
            "seed": seed, "accuracy": "binary", "error": len(wrong), "estimate": len(named),
            "silent": sum(tuple(cell) not in named for cell in wrong), "how": signs.how,
        }  # fmt: skip
