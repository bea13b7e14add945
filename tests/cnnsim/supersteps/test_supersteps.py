"""Transients in supersteps: the bits of the whole grid, and which blocks are computed."""

from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim.network import PERIODIC, LayeredTemplate, Table, Template, Term
from cnnsim.planning.plan import make_plan
from cnnsim.supersteps.block_plan import reach_of
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import Engine
from tests.kits.supersteps import BIAS, MASK, MIXED, RANDOM, SHAPE, U, X, one


def assert_same(template: Any, engine: Engine, **task: Any) -> Any:
    """Assert that a run in supersteps has the bits, the time and the rate of one of the whole grid."""
    whole = cnnsim.run_transient(template, **task)
    parts = cnnsim.run_transient(template, engine=engine, **task)
    assert parts.x.dtype == whole.x.dtype
    assert parts.x.tobytes() == whole.x.tobytes()
    assert (parts.t, parts.settled, parts.distance) == pytest.approx(
        (whole.t, whole.settled, whole.distance), nan_ok=True
    )
    assert parts.rate == pytest.approx(whole.rate, rel=1e-15, nan_ok=True)
    return parts


@pytest.mark.parametrize("boundary", ["zero-flux", "periodic", "fixed:0.3,-0.2"])
@pytest.mark.parametrize(("dtype", "depth", "side"), [("float32", 7, 16), ("float64", 64, 20), ("float32", 1, 40)])
def test_a_fixed_duration_gives_the_bits_of_the_whole_grid(boundary: str, dtype: Any, depth: int, side: int) -> None:
    time = 0.4 if depth == 1 else 2.1
    engine = one(side=side, depth=depth)
    assert_same(MIXED, engine, state=X, input=U, boundary=boundary, duration=time, dtype=dtype)


@pytest.mark.parametrize("boundary", ["zero-flux", "periodic", "fixed:0.3,-0.2"])
@pytest.mark.parametrize("more", [{}, {"mask": MASK - 0.6, "bias": BIAS}])
def test_a_run_until_settled_ends_at_the_same_step(boundary: str, more: dict[str, Any]) -> None:
    assert_same(MIXED, one(side=24, depth=35), state=X, input=U, boundary=boundary, **more)


@pytest.mark.parametrize("backend", ["opencl", "reference"])
def test_every_backend_gives_its_own_bits(backend: str) -> None:
    pytest.importorskip("pyopencl") if backend == "opencl" else None
    assert_same(MIXED, one(side=24, depth=9), state=X, input=U, boundary="periodic", duration=1.5, backend=backend)
    assert_same(MIXED, one(side=24, depth=40), state=X, input=U, mask=MASK - 0.7, backend=backend)


OTHER = Template(0.5, terms=[Term([[0.0, 0.2, 0.0], [0.3, 0.0, 0.0], [0.0, 0.0, 0.0]], layer=0)])
HALF = Table("linear", (-1, 0, 1), (-1, 0.2, 1))
KINDS: dict[str, tuple[Any, dict[str, Any]]] = {
    "two layers": (
        LayeredTemplate([MIXED, OTHER], [1.0, 2.0]),
        {"state": np.stack([X, BIAS]), "input": np.stack([U, U]), "duration": 1.5},
    ),
    "a difference through a table": (
        Template(1.0, 0.5, terms=[Term(np.full((3, 3), 0.1), "y_kl - y_ij", HALF)]),
        {"state": X, "input": U, "duration": 1.5},
    ),
    "weights that differ from cell to cell": (
        Template(1.2, terms=[Term(RANDOM.uniform(-0.2, 0.2, (3, 3, *SHAPE)), "y_kl")]),
        {"state": X, "duration": 1.5, "boundary": "periodic"},
    ),
    "a term of the input": (
        Template([[0, 0.2, 0], [0.2, 1, 0.2], [0, 0.2, 0]], 0.5, terms=[Term(np.full((3, 3), 0.1), "u_kl - u_ij")]),
        {"state": X, "input": U, "duration": 1.5},
    ),
    "discrete time": (
        Template([[0, 0.3, 0], [0.3, 2, 0.3], [0, 0.3, 0]], 1.5, 0.1),
        {"state": np.sign(X), "input": U, "cell": "discrete-time"},
    ),
    "the closed form": (Template(2.0, [[0, 1, 0], [1, 1, 0], [0, 0, 0]], 0.1), {"state": X, "input": U}),
    "no neighbours, by steps, to rest": (
        Template(2.067), {"state": np.stack([X, U]), "scheme": "euler", "step": 0.1, "boundary": "periodic"},
    ),
    "two stages": (MIXED, {"state": X, "input": U, "scheme": "heun", "step": 0.1, "duration": 1.0}),
    "full range": (MIXED, {"state": X, "input": U, "cell": "full-range", "duration": 1.0}),
    "two grids": (MIXED, {"state": np.stack([X, -X]), "input": np.stack([U, X]), "duration": 1.0}),
    "the picture as state and input": (MIXED, {"state": X, "input": X, "duration": 1.0}),
    "a radius of 2": (Template(np.full((5, 5), 0.1), 0.3), {"state": X, "input": U, "duration": 1.0}),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_template_gives_the_bits_of_the_whole_grid(kind: str) -> None:
    template, task = KINDS[kind]
    assert_same(template, one(side=20, depth=4), **task)


def test_blocks_are_read_with_a_neighbour_each_way_where_weights_are_zero() -> None:
    """Compiled loops read one neighbour with weight 0; NaN in unset memory would spread from there."""
    steps = make_plan(Template(2.067), (8, 9), PERIODIC, scheme="euler", step=0.1)
    assert (steps.method, reach_of(steps)) == ("stepped", 1)
    assert reach_of(make_plan(Template(2.067), (8, 9), PERIODIC)) == 0  # the closed form


def test_a_block_with_its_halo_has_every_cell_in_reach() -> None:
    for kind in ("periodic", "zero-flux"):
        blocks = Blocks((13, 7), 5, cnnsim.Boundary(kind))
        plane = np.arange(13 * 7).reshape(13, 7)
        for number in range(len(blocks)):
            for halo in (0, 2, 9):
                rows, cols, ((p0, p1), (q0, q1)) = blocks.around(number, halo)
                (r0, r1), (c0, c1) = blocks.area(number)
                assert np.array_equal(plane[rows[:, None], cols][p0:p1, q0:q1], plane[r0:r1, c0:c1])
                if kind == "periodic":
                    around = np.pad(plane, halo, mode="wrap")[r0 : r1 + 2 * halo, c0 : c1 + 2 * halo]
                    assert np.array_equal(plane[rows[:, None], cols], around)
