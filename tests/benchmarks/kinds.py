"""Terms compared with nine linear taps: tables, delays, local weights, layers and other characteristics."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from cnnsim import library
from cnnsim.backends.base import Backend
from cnnsim.network import AnyTemplate, LayeredTemplate, Template, Term, fixed
from cnnsim.network.table import lines
from cnnsim.planning.plan import make_plan
from tests.benchmarks.dense import NINE, H, backends
from tests.benchmarks.race import Row, race

N, STEPS = 512, 100


def kinds() -> Iterator[tuple[str, AnyTemplate, Any]]:
    """Yield name, template and cell."""
    weak, cell = NINE.astype(float) / 10, "chua-yang"
    yield "median, 8 steps of u - x", library.load("median").template, cell
    yield (
        "9 tables of 4 lines",
        Template([[1.0]], terms=[Term(weak, "y_kl", lines((-1, -1), (0, 0), (0.5, 0), (1, 1)))]),
        cell,
    )
    yield "9 delayed taps", Template([[0.5]], terms=[Term(weak, delay=1.0)]), cell
    yield "9 taps a cell of its own", Template([[0.5]], terms=[Term(weak[..., None, None] * np.ones((N, N)))]), cell
    coupled = [Template(weak, terms=[Term([[weight]], layer=other)]) for weight, other in ((-0.5, 1), (0.5, 0))]
    yield "two layers of 10 taps", LayeredTemplate(coupled), cell
    yield "9 taps, sigmoid", Template(weak), {"model": "chua-yang", "characteristic": "tanh"}


def transient(backend: Backend, template: AnyTemplate, cell: Any) -> Callable[[], object]:
    """Return a run, planes already loaded."""
    rng = np.random.default_rng(0)
    shape = (len(template.layers), N, N) if isinstance(template, LayeredTemplate) else (N, N)
    plan = make_plan(template, shape, fixed(0), duration=STEPS * H, scheme="euler", step=H, cell=cell)
    x, u = (backend.load(rng.uniform(-1, 1, shape), "lam") for _ in range(2))

    def run() -> None:
        outcome = backend.transient(plan, x, u if template.reads_input else None)
        backend.count(backend.convert(outcome.x, "llm"))  # waits for the device

    return run


def against_linear(rounds: int) -> list[Row]:
    """All kinds [steps of a cell a second], as a share of the rate of nine linear taps."""
    rows = []
    for who, backend in backends().items():
        races = {"nine taps": (Template(NINE), "chua-yang"), **{name: (t, cell) for name, t, cell in kinds()}}
        seconds = race({name: transient(backend, *given) for name, given in races.items()}, rounds)
        layers = {name: len(t.layers) if isinstance(t, LayeredTemplate) else 1 for name, (t, _) in races.items()}
        rate = {name: 1e-9 * N * N * STEPS * layers[name] / seconds[name] for name in races}
        for name in races:
            if name != "nine taps":
                ratio = {"nine taps": rate[name] / rate["nine taps"]}
                rows.append(Row(f"kinds {N}^2, {name}", who, rate[name], "Gcs", ">= 0.1 x nine taps", ratio))
    return rows
