"""Random networks of all kinds, and a state compared with the reference's."""

from typing import Any, get_args

import numpy as np
from hypothesis import strategies as st

from cnnsim import Boundary, Template, fixed
from cnnsim.backends.base import Backend, Outcome
from cnnsim.network import Cell, Characteristic, Frames, LayeredTemplate, Table, Term
from cnnsim.network.boundary import BoundaryKind
from cnnsim.network.table import lines
from cnnsim.planning.scheme import SCHEMES
from cnnsim.task import Task
from tests.kits.backends import REFERENCE, TOLERANCE

REPEATING = [Boundary(kind) for kind in get_args(BoundaryKind) if kind not in ("fixed", "reflecting")]
"""All boundaries whose virtual cells repeat real ones."""
BOUNDARIES = [*REPEATING, fixed(-1.0), fixed(0.3, -0.7)]
ARGUMENTS = ["y_kl", "u_kl", "x_kl", "u_kl - u_ij", "y_kl - y_ij", "x_kl - x_ij", "u_kl - x_ij", "y_kl - u_ij"]
CELLS = [
    Cell(), Cell("full-range"), Cell("chua-yang", Characteristic("tanh", 2.0)),
    Cell("chua-yang", Characteristic(slope=3)),
    Cell("chua-yang", Characteristic("table", table=lines((-1.5, -1), (0, 0.2), (1, 1)))),
    Cell("discrete-time", Characteristic()),
]  # fmt: skip


def assert_like_the_reference(backend: Backend, task: Task, bound: float) -> Outcome:
    """Run a task on a backend and on the reference: the same end, within the tolerance times the ``bound`` of |x|.

    In float64 the times and whether it settled are the same, and the largest rate to nine places.
    """
    law = task.start(REFERENCE)
    ours = law if backend.name == REFERENCE.name else task.start(backend)
    x = backend.read(ours.x)
    assert x.dtype == backend.dtype
    assert x.shape == task.state.shape
    assert np.abs(x - law.x).max() <= TOLERANCE[backend.dtype.name] * bound
    if backend.dtype == "float64":
        assert (ours.t, ours.settled) == (law.t, law.settled)
        np.testing.assert_allclose(ours.rate, law.rate, rtol=1e-9, atol=1e-11)
    return ours


def number_of_examples(backend: Backend) -> int:
    """How many random rules: an OpenCL device compiles each for seconds, and the reference is compared with itself."""
    return {"opencl": 2, "reference": 1}.get(backend.name, 20)


@st.composite
def linear_tasks(draw: st.DrawFn) -> list[dict[str, Any]]:
    """Five random transients of one rule (an OpenCL device compiles each rule) with a time and planes of their own.

    Rounding errors cannot grow beyond about fifty times their size: an error in x grows at most like
    exp((sum|A| - 1) t), so the running time is kept below ln(50) / (sum|A| - 1).
    """
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    r, s = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    a = rng.normal(size=(2 * r + 1, 2 * r + 1)) * (
        rng.random((2 * r + 1, 2 * r + 1)) < draw(st.sampled_from([0.3, 1.0]))
    )
    b = rng.normal(size=(2 * s + 1, 2 * s + 1))
    a *= draw(st.floats(0.5, 4)) / max(np.abs(a).sum(), 1e-9)
    b /= np.abs(b).sum()
    longest = min(5.0, np.log(50) / max(np.abs(a).sum() - 1, 0.1))
    rule = {
        "template": Template(a, b, rng.normal()),
        "boundary": draw(st.sampled_from(BOUNDARIES)),
        "scheme": draw(st.sampled_from([None, *SCHEMES])),
        "cell": draw(st.sampled_from(["chua-yang", "full-range"])),
    }

    def planes() -> dict[str, Any]:
        shape: tuple[int, ...] = (draw(st.integers(1, 20)), draw(st.integers(1, 20)))
        if draw(st.booleans()):
            shape = (draw(st.integers(1, 3)), *shape)
        return {
            "state": rng.uniform(-1, 1, shape),
            "input": rng.uniform(-1, 1, shape),
            "bias": rng.normal(size=shape) if draw(st.booleans()) else None,
            "mask": rng.uniform(-1, 1, shape) if draw(st.booleans()) else None,
            "duration": longest * draw(st.floats(0.1, 1)),
        }

    return [{**rule, **planes()} for _ in range(5)]


def settling_task(seed: int) -> dict[str, Any]:
    """A random transient that is to settle, or runs for 1.27: any radius, scheme, cell, boundary, batch or none."""
    rng = np.random.default_rng(seed)
    r, s = (int(v) for v in rng.integers(1, 4, 2))
    a = rng.normal(size=(2 * r + 1, 2 * r + 1)) * (rng.random((2 * r + 1, 2 * r + 1)) < rng.choice([0.3, 1.0]))
    b = rng.normal(size=(2 * s + 1, 2 * s + 1))
    shape = tuple(int(v) for v in rng.integers(1, 24, 2))
    shape = (int(rng.integers(1, 4)), *shape) if rng.random() < 0.4 else shape
    maps: dict[str, Any] = {}
    if rng.random() < 0.5:
        maps["bias"] = rng.normal(size=shape)
    if rng.random() < 0.5:
        maps["mask"] = rng.uniform(-1, 1, shape)
    return {
        "template": Template(2 * a / max(np.abs(a).sum(), 1e-9), b / np.abs(b).sum(), rng.normal()),
        "state": rng.uniform(-1, 1, shape), "input": rng.uniform(-1, 1, shape), **maps,
        "boundary": [*REPEATING, fixed(0.5, -0.3), fixed(-1.0)][rng.integers(2 + len(REPEATING))],
        "scheme": [None, *SCHEMES][rng.integers(1 + len(SCHEMES))], "cell": rng.choice(["chua-yang", "full-range"]),
        "duration": [1.27, "settled"][rng.integers(2)], "limit": 15.0,
        "without": ["blocking"] if rng.random() < 0.2 else [],
    }  # fmt: skip


def random_table(rng: np.random.Generator) -> Table:
    """Linear: a step would turn rounding errors into jumps; the tests of tables have those."""
    at = np.sort(rng.uniform(-2, 2, 4)) + np.arange(4) * 0.5
    return lines(*zip(at.tolist(), rng.uniform(-0.5, 0.5, 4).tolist(), strict=True))


def random_term(rng: np.random.Generator, shape: tuple[int, int], layers: int, delays: bool) -> Term:
    side = int(rng.choice([1, 3, 5]))
    weights = rng.normal(size=(side, side)) * 0.3 / side**2
    varying = rng.random() < 0.3
    return Term(
        weights[..., None, None] * rng.uniform(0.5, 1, shape) if varying else weights,
        str(rng.choice(ARGUMENTS)),
        random_table(rng) if rng.random() < 0.7 else None,
        str(rng.choice(ARGUMENTS)) if rng.random() < 0.3 else None,
        float(rng.choice([0.1, 0.3, 1.0])) if delays and rng.random() < 0.6 else 0.0,
        int(rng.integers(layers)) if rng.random() < 0.4 else None,
    )


def general_task(seed: int, planes: int) -> dict[str, Any]:
    """A random network with terms, cell, boundary and scheme by the seed; its planes by both numbers."""
    rng = np.random.default_rng(seed)

    def coin() -> bool:
        return bool(rng.random() < 0.5)

    layers, grid = int(rng.integers(1, 4)), (int(rng.integers(1, 10)), int(rng.integers(1, 10)))
    cell, delays = CELLS[rng.integers(len(CELLS))], coin()
    if cell.model == "discrete-time":
        delays = False
    parts = [
        Template(rng.normal(size=(3, 3)) * 0.3, rng.normal(size=(3, 3)) * 0.3, rng.normal(),
                 terms=[random_term(rng, grid, layers, delays) for _ in range(rng.integers(1, 4))])
        for _ in range(layers)
    ]  # fmt: skip
    constants = None if cell.model == "discrete-time" else rng.uniform(0.5, 3, layers).tolist()
    boundary = BOUNDARIES[rng.integers(4)]
    scheme = None if cell.model == "discrete-time" else str(rng.choice(["euler", "heun", "exponential-euler"]))
    shape: tuple[int, ...] = (layers, *grid) if layers > 1 else grid
    rng = np.random.default_rng([seed, planes])
    if coin():
        shape = (int(rng.integers(1, 4)), *shape)
    frames = coin()
    u = rng.uniform(-1, 1, (3, *shape))
    period = 1.0 if cell.model == "discrete-time" else 0.4
    return {
        "template": LayeredTemplate(parts, constants) if layers > 1 else parts[0],
        "state": rng.uniform(-1, 1, shape),
        "input": Frames(list(u), period) if frames else u[0],
        "bias": Frames(list(rng.normal(size=(2, *shape))), period) if coin() else rng.normal(size=shape),
        "mask": rng.uniform(-1, 1, shape) if coin() else None,
        "boundary": boundary,
        "scheme": scheme,
        "cell": cell,
        "duration": 3.0 if cell.model == "discrete-time" else 1.2,
    }
