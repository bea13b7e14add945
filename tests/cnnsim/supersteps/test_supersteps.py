"""One grid in supersteps: to the bit that of the whole grid, blocks that sleep left out."""

from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim.backends.cpu import block
from cnnsim.network import PERIODIC, LayeredTemplate, Table, Template, Term
from cnnsim.planning.duration import Duration
from cnnsim.planning.plan import make_plan
from cnnsim.supersteps import block_task, run
from cnnsim.supersteps.block_plan import reach_of, wants_small_blocks
from cnnsim.supersteps.blocks import Blocks, runs
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.store import GridStore
from cnnsim.support import Array
from tests.kits.supersteps import BIAS, MASK, MIXED, RANDOM, SHAPE, U, X, one


def assert_same(template: Any, engine: Engine, **task: Any) -> Any:
    """Check a run in supersteps against one of the whole grid: to the bit, with time and rate."""
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
def test_a_fixed_time_is_that_of_the_whole_grid(boundary: str, dtype: Any, depth: int, side: int) -> None:
    time = 0.4 if depth == 1 else 2.1
    engine = one(side=side, depth=depth)
    assert_same(MIXED, engine, state=X, input=U, boundary=boundary, duration=time, dtype=dtype)


@pytest.mark.parametrize("boundary", ["zero-flux", "periodic", "fixed:0.3,-0.2"])
@pytest.mark.parametrize("more", [{}, {"mask": MASK - 0.6, "bias": BIAS}])
def test_rest_is_found_at_the_same_step(boundary: str, more: dict[str, Any]) -> None:
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
def test_every_kind_of_template_is_cut_without_a_trace(kind: str) -> None:
    template, task = KINDS[kind]
    assert_same(template, one(side=20, depth=4), **task)


def holes() -> Array:
    """Return a picture with a few closed curves: the wave comes in from the edge and leaves much alone."""
    picture = np.full((96, 96), -1.0)
    picture[30:70, 40:42] = picture[30:70, 60:62] = picture[30:32, 40:62] = picture[68:70, 40:62] = 1.0
    return picture


def test_cells_without_neighbours_have_a_cell_around_their_blocks_all_the_same() -> None:
    """Loops over rows multiply it by 0, which unwritten memory may make NaN: seldom, so it is asked for here."""
    steps = make_plan(Template(2.067), (8, 9), PERIODIC, scheme="euler", step=0.1)
    assert (steps.method, reach_of(steps)) == ("stepped", 1)
    assert reach_of(make_plan(Template(2.067), (8, 9), PERIODIC)) == 0  # the closed form looks at none


def test_blocks_that_sleep_are_left_out_and_catch_up_to_the_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    tasks: list[int] = []

    def counted(task: Any) -> Any:
        if not task.behind:
            tasks.append(task.block)
        return block_task.run_block(task)

    monkeypatch.setattr(run, "run_block", counted)
    entry = cnnsim.library.load("hole-filler")
    task = entry.task(holes()) | {"duration": 4.0}
    found = assert_same(entry.template, one(side=12, depth=10), **task)
    with_sleep, supersteps = len(tasks) - 64, round(4.0 / found.plan.step / 10)  # the first check is of all blocks
    assert with_sleep < 0.85 * 64 * supersteps
    tasks.clear()
    assert_same(entry.template, one(side=12, depth=10), **task, without=["sleep"])
    assert len(tasks) == 64 * supersteps


def test_blocks_are_small_only_where_tiles_in_them_do_not_sleep() -> None:
    entry, picture = cnnsim.library.load("hole-filler"), np.where(RANDOM.random((256, 256)) < 0.3, 1.0, -1.0)
    found = cnnsim.run_transient(entry.template, **entry.task(picture) | {"duration": 0.4}, engine=one())
    assert "256 x 256 cells, 1 of them" in found.plan.explain()
    cases: list[tuple[Duration, str, bool, bool]] = [
        (1000.0, "cpu", False, False), (1000.0, "cpu", True, True), (10.0, "cpu", True, False),
        (1000.0, "opencl", False, True), ("settled", "cpu", False, True),
    ]  # fmt: skip
    for duration, backend, has_mask, small in cases:
        plan = make_plan(entry.template, (64, 64), entry.boundary, duration=duration)
        assert wants_small_blocks(plan, backend, has_mask=has_mask) == small


LINES = Template([[0, 1, 0], [1, 3, 1], [0, 1, 0]], 4.0, -1.0)
SLOW = Template(
    [[0.0, 0.2, 0.0], [0.6, 2.2, 0.0], [0.0, 0.3, 0.1]], [[0.0, 0.0, 0.1], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]], 0.6
)


@pytest.mark.parametrize("boundary", ["zero-flux", "periodic", "fixed:-1", "fixed:0.3,-0.2"])
@pytest.mark.parametrize(("template", "step", "dtype"), [(LINES, 0.1, "float32"), (SLOW, 0.7, "float64")])
def test_tiles_sleep_in_a_block_to_the_bit(
    template: Template, step: float, dtype: str, boundary: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept, inner = list[bool](), block.slept

    def watched(*given: Any) -> Any:
        slept.append((end := inner(*given)) is not None)
        return end

    monkeypatch.setattr(block, "slept", watched)
    picture = np.full((210, 170), 1.0)
    picture[40:43, 20:150] = picture[120:190, 60:62] = -1.0
    task = {"input": picture, "boundary": boundary, "scheme": "euler", "step": step, "dtype": dtype}
    assert_same(template, one(side=100, depth=36), state=np.full(picture.shape, 1.0), duration=70 * step, **task)
    assert any(slept)
    monkeypatch.setattr(block, "FEW", 1.0)  # also where all are awake
    start = np.where(RANDOM.random(picture.shape) < 0.5, 1.0, -1.0)
    assert_same(template, one(side=130, depth=20), state=start, duration=40 * step, **task)


def test_what_sleeps_wakes_up_when_a_wave_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    woken: list[int] = []

    def watched(task: Any) -> Any:
        if task.behind:
            woken.append(task.behind)
        return block_task.run_block(task)

    monkeypatch.setattr(run, "run_block", watched)
    entry = cnnsim.library.load("hole-filler")
    assert_same(entry.template, one(side=8, depth=10), **entry.task(holes()[28:68, 36:68]) | {"duration": 12.0})
    assert len(woken) > 2
    assert max(woken) > 20


def test_what_lies_around_a_block_is_every_cell_that_can_reach_it() -> None:
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
    assert runs(np.array([5, 6, 0, 1, 2]), 0) == [((0, 2), (5, 7)), ((2, 5), (0, 3))]
    assert runs(np.array([3, 4, 5, 6]), 5) == [((0, 2), (3, 5)), ((2, 4), (5, 7))]


def test_a_picture_that_is_state_and_input_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    read, inner = list[Any](), GridStore.read

    def counted(store: GridStore, plane: Any, *rest: Any) -> Array:
        read.append(plane)
        return inner(store, plane, *rest)

    monkeypatch.setattr(GridStore, "read", counted)
    assert_same(MIXED, one(side=40, depth=4), state=X, input=X, duration=0.8)
    assert read[:2] == ["input"] * 2  # two blocks, their first superstep
    assert read[2:6] == ["input", {0: "x0", 1: "x0"}] * 2  # by then the states have gone on
