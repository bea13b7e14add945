"""Dense Euler transients: sizes, templates and backends, compared with peers."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from cnnsim.backends import get
from cnnsim.backends.base import Backend
from cnnsim.network import Template, fixed
from cnnsim.planning.plan import make_plan
from cnnsim.support import InputError
from tests.benchmarks.peers import installed
from tests.benchmarks.race import Row, race, versus

NINE = np.array([[0.1, 0.2, 0.15], [0.3, 1.5, -0.2], [0.05, -0.1, 0.12]], np.float32)
CROSS = np.array([[0, 0.2, 0], [0.3, 1.5, -0.2], [0, -0.1, 0]], np.float32)
ISOTROPIC = np.array([[0.1, 0.2, 0.1], [0.2, 0.5, 0.2], [0.1, 0.2, 0.1]], np.float32)
H = 0.1


def backends() -> dict[str, Backend]:
    """Return the backends that are there, in float32."""
    found: dict[str, Backend] = {"cpu": get("cpu", "float32")}
    with suppress(InputError):
        found["opencl"] = get("opencl", "float32")
    return found


def transient(backend: Backend, a: Any, n: int, steps: int) -> Callable[[], object]:
    """Return a run of a number of steps on n x n cells, with loaded planes."""
    rng = np.random.default_rng(0)
    template = Template(a)
    plan = make_plan(template, (n, n), fixed(0), duration=steps * H, scheme="euler", step=H)
    x, bias = (backend.load(rng.uniform(-s, s, (n, n)), "lam") for s in (1.0, 0.1))

    def run() -> None:
        outcome = backend.transient(plan, x, None, bias)
        backend.count(backend.convert(outcome.x, "llm"))  # waits for the device

    return run


def against_peers(n: int, steps: int, targets: Mapping[str, str], rounds: int) -> list[Row]:
    """Nine different taps on n x n cells, backends and peers alternately; ``targets`` of each backend."""
    rng = np.random.default_rng(0)
    x, w = (rng.uniform(-s, s, (n, n)).astype(np.float32) for s in (1.0, 0.1))
    runners = {name: transient(backend, NINE, n, steps) for name, backend in backends().items()}
    ours = list(runners)
    runners |= {name: peer(x, w, NINE, H, steps) for name, peer in installed(fast_only=n > 1000)}
    seconds = race(runners, rounds)
    rows = []
    for who in ours:
        rate = 1e-9 * n * n * steps / seconds[who]
        others = {name: ratio for name, ratio in versus(seconds, who).items() if name not in ours}
        rows.append(Row(f"dense {n}^2, nine taps", who, rate, "Gcs", targets[who], others))
    return rows


def templates_and_sizes(rounds: int) -> list[Row]:
    """Cross and isotropic compared with nine taps, and a large grid with a small one."""
    rows = []
    for who, backend in backends().items():
        runners = {
            "nine taps": transient(backend, NINE, 2048, 50),
            "cross": transient(backend, CROSS, 2048, 50),
            "isotropic": transient(backend, ISOTROPIC, 2048, 50),
            "nine taps 512^2": transient(backend, NINE, 512, 400),
            "nine taps 8192^2": transient(backend, NINE, 8192, 100),
        }
        seconds = race(runners, rounds)
        cells = {"nine taps 512^2": 512**2 * 400, "nine taps 8192^2": 8192**2 * 100}
        rate = {name: 1e-9 * cells.get(name, 2048**2 * 50) / s for name, s in seconds.items()}
        for name in ("cross", "isotropic"):
            ratio = {"nine taps": rate[name] / rate["nine taps"]}
            rows.append(Row(f"dense 2048^2, {name}", who, rate[name], "Gcs", ">= 1.2 x nine taps", ratio))
        ratio = {"512^2": rate["nine taps 8192^2"] / rate["nine taps 512^2"]}
        rows.append(Row("dense 8192^2, nine taps", who, rate["nine taps 8192^2"], "Gcs", ">= 0.8 x 512^2", ratio))
    return rows
