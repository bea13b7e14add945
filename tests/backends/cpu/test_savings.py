"""Every way of doing less gives what doing all gives: the same bits, or a stated bound and the same signs."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import library
from cnnsim.backends import get
from cnnsim.backends.cpu.backend import CpuBackend
from cnnsim.backends.cpu.tiles.euler import TILE_COLS
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.convergence import NotSettledError
from cnnsim.network import PERIODIC, ZERO_FLUX, Boundary, Template, fixed
from cnnsim.planning.plan import make_plan
from cnnsim.planning.savings import MOST_HALO
from cnnsim.result import Result
from cnnsim.support import InputError
from cnnsim.transient import run_transient

BACKENDS = {name: get("cpu", name) for name in ("float32", "float64")}
BOUNDARIES = (fixed(-1), fixed(0.25), ZERO_FLUX, PERIODIC)
SHAPES = ((1, 1), (1, 7), (9, 1), (2, 3), (5, 40), (37, 66), (70, 131), (30, 2300), (1100, 20))

CROSS = Template([[0, 0.4, 0], [0.3, 1.5, -0.2], [0, 0.25, 0]], 0.5, 0.1, "cross")
NINE = Template(
    [[0.1, 0.4, -0.1], [0.3, 1.2, -0.2], [0.05, 0.25, 0.15]], [[0.0, 0.2, 0], [0.0, 1, 0], [0.0, 0, -0.3]], -0.1
)
ISOTROPIC = Template([[0.1, 0.2, 0.1], [0.2, 0.6, 0.2], [0.1, 0.2, 0.1]], 0.3, 0.05, "isotropic")
ROW = Template([[0, 0, 0], [1, 2, -1], [0, 0, 0]], 0, 0, "row")
WIDE = Template(np.outer([1, -2, 3, 2, 1], [1, 0, 2, -1, 0.5]) / 8, 0.5, 0, "radius 2")
WIDEST = Template(np.eye(11) / 8 + np.diag(np.full(11, 0.02))[::-1], 0.5, 0, "radius 5")
HOLES = Template([[0, 1, 0], [1, 3, 1], [0, 1, 0]], 4, -1, "holes")
TEMPLATES = (CROSS, NINE, ISOTROPIC, ROW, WIDE, WIDEST, HOLES)


def run(template: Template, x: Any, boundary: Boundary, dtype: str = "float32", **task: Any) -> Result:
    try:
        return run_transient(template, state=x, input=np.sin(9 * x), boundary=boundary, backend=BACKENDS[dtype], **task)
    except NotSettledError as error:
        return error.result


def states(shape: tuple[int, ...], seed: int = 0) -> Any:
    return np.random.default_rng(seed).uniform(-1.5, 1.5, shape)


def test_a_row_of_a_tile_with_its_halo_fits_into_a_row_of_the_buffers() -> None:
    vectors = -(-(TILE_COLS + 2 * MOST_HALO) // PAD)
    assert PAD * vectors + 2 * PAD <= STRIDE


def same(one: Result, other: Result) -> None:
    np.testing.assert_array_equal(one.x, other.x)
    assert (one.t, one.settled) == (other.t, other.settled)
    np.testing.assert_equal(one.rate, other.rate)


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("template", TEMPLATES, ids=lambda t: t.name)
@pytest.mark.parametrize("dtype", BACKENDS)
def test_many_steps_a_pass_are_one_step_a_pass_bit_for_bit(template: Template, boundary: Boundary, dtype: str) -> None:
    for shape in SHAPES:
        x = states(shape)
        same(run(template, x, boundary, dtype, duration=3.7),
             run(template, x, boundary, dtype, duration=3.7, without=["blocking"]))  # fmt: skip


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("template", TEMPLATES, ids=lambda t: t.name)
def test_blocked_float64_is_the_reference_bit_for_bit(template: Template, boundary: Boundary) -> None:
    for shape in SHAPES:
        x = states(shape)
        task: dict[str, Any] = {"state": x, "input": np.sin(9 * x), "boundary": boundary, "duration": 2.3}
        np.testing.assert_array_equal(
            run_transient(template, **task, dtype="float64").x, run_transient(template, **task, backend="reference").x
        )


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("dtype", BACKENDS)
def test_the_drive_of_nine_taps_is_added_up_on_the_way_to_rest(boundary: Boundary, dtype: str) -> None:
    """A bias of 0 or a mask without cells leaves all rows to the loops for any taps."""
    for a in (0.5, 1.0, 2.0):
        template = Template(a, np.arange(-4.0, 5.0).reshape(3, 3) + 0.1, 0.3)
        for shape in ((1, 7), (3, 2), (4, 3), (2, 37, 66)):
            x = states(shape)
            quick = run(template, x, boundary, dtype)
            same(quick, run(template, x, boundary, dtype, bias=np.zeros(shape)))
            same(quick, run(template, x, boundary, dtype, mask=np.full(shape, -1.0)))


@pytest.mark.parametrize("a", [0.75, 1.0, 1.25, 3.5])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
@pytest.mark.parametrize("dtype", BACKENDS)
def test_rows_that_begin_inside_and_drive_themselves_on_come_to_rest_as_any(a: float, cell: Any, dtype: str) -> None:
    """Quarters: cells begin right on 1 and -1, and some have a rate of 0; of the rows some have a cell beyond."""
    rng = np.random.default_rng(7)
    template = Template(a, rng.integers(-3, 4, (3, 3)) / 4 + np.where(np.eye(3), 0.25, 0.0), 0.25, "quarters")
    shape, widest = (2, 29, 83), 4
    x, u = rng.integers(-widest, widest + 1, shape) / 4, rng.integers(-widest, widest + 1, shape) / 4
    if cell == "chua-yang":
        x[:, ::3, 5], x[:, 1::6, 41], x[1, ::4, -1] = 1.25, -7.0, 2.0  # 41 is in the middle, which is looked at first
    task: dict[str, Any] = {"input": u, "boundary": ZERO_FLUX, "cell": cell, "backend": BACKENDS[dtype]}
    quick = run_transient(template, state=x, **task)
    same(quick, run_transient(template, state=x, mask=np.full(shape, -1.0), **task))
    assert quick.rate == 0  # as only a closed form ends


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("template", [CROSS, NINE, ISOTROPIC, HOLES, WIDE], ids=lambda t: t.name)
@pytest.mark.parametrize("dtype", BACKENDS)
def test_sleeping_tiles_change_no_bit(template: Template, boundary: Boundary, dtype: str) -> None:
    for shape in ((1, 1), (3, 200), (70, 131)):
        x = 1.3 * states(shape, 3)
        same(run(template, x, boundary, dtype, limit=40.0),
             run(template, x, boundary, dtype, limit=40.0, without=["sleep"]))  # fmt: skip


@pytest.mark.parametrize(
    ("weight", "step", "boundary", "dtype"),
    [(3.9, 0.08, ZERO_FLUX, "float64"), (3.9, 0.1, PERIODIC, "float32"), (3.9, 0.12, fixed(-1), "float64")],
)
def test_what_a_fast_front_runs_into_has_taken_all_its_steps(
    weight: float, step: float, boundary: Boundary, dtype: Any
) -> None:
    # a cell a step, and what it comes to was on its way to -1.01 when it fell asleep: how far that is decides its bits
    around = np.array([[0, weight, 0], [weight, 1.2, weight], [0, weight, 0]])
    template = Template(around, z=around.sum() - 1.01)
    state = np.full((96, 480), -2.0)
    state[20:23, 30:33] = 3.0
    task: dict[str, Any] = {"state": state, "boundary": boundary, "step": step, "scheme": "euler", "dtype": dtype}
    asleep, awake = (run_transient(template, **task, without=without) for without in ((), ("sleep",)))
    assert asleep.x.tobytes() == awake.x.tobytes()


@pytest.mark.parametrize("boundary", [fixed(-1), ZERO_FLUX, PERIODIC], ids=str)
def test_sleeping_tiles_wake_up_where_a_wave_comes(boundary: Boundary) -> None:
    rng = np.random.default_rng(8)
    picture = np.where(rng.random((150, 210)) > 0.93, 1.0, -1.0)
    picture[40:110, 60] = picture[40:110, 160] = picture[40, 60:160] = picture[110, 60:160] = 1
    for name in ("hole-filler", "connected-components-horizontal", "shadow-left"):
        entry = library.load(name)
        task: dict[str, Any] = {**entry.planes(picture), "boundary": boundary, "limit": 900.0}
        results = []
        for without in ([], ["sleep"], ["sleep", "blocking", "sparse taps"]):
            try:
                results.append(run_transient(entry.template, **task, without=without))
            except NotSettledError as error:
                results.append(error.result)
        same(results[0], results[1])
        same(results[0], results[2])


@settings(max_examples=60)
@given(
    st.lists(st.sampled_from([0.0, 0.0, 1.0, -0.5, 0.3]), min_size=9, max_size=9),
    st.sampled_from(BOUNDARIES),
    st.tuples(st.integers(1, 40), st.integers(1, 90)),
    st.sampled_from(["sparse taps", "blocking", "sleep"]),
    st.sampled_from(sorted(BACKENDS)),
    st.integers(0, 99),
)
def test_any_template_with_and_without(
    a: list[float], boundary: Boundary, shape: tuple[int, int], saving: str, dtype: str, seed: int
) -> None:
    template = Template(np.reshape(a, (3, 3)) + np.diag([0, 1.5, 0]), 0.7, 0.1)
    x = states(shape, seed)
    step = 0.1 if template.symmetric else 0.05
    same(run(template, x, boundary, dtype, limit=8.0, step=step),
         run(template, x, boundary, dtype, limit=8.0, step=step, without=[saving]))  # fmt: skip


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
def test_shared_sums_stay_within_rounding(boundary: Boundary) -> None:
    """Another order of nine additions: each step is off by 10 roundings at most, and this template damps them."""
    x = states((90, 200))
    one, other = (run(ISOTROPIC, x, boundary, duration=6.0, without=w) for w in ([], ["shared sums"]))
    assert np.abs(one.x - other.x).max() <= 60 * 10 * np.finfo(np.float32).eps * 3
    assert (np.sign(one.y) == np.sign(other.y))[np.abs(one.x) > 1e-3].all()


@pytest.mark.parametrize("name", ["edge", "threshold", "erosion-square", "logic-not"])
def test_the_closed_form_is_where_the_steps_go(name: str) -> None:
    entry = library.load(name)
    rng = np.random.default_rng(1)
    planes = entry.planes(np.where(rng.random((30, 50)) > 0.5, 1.0, -1.0))
    task: dict[str, Any] = {**planes, "boundary": entry.boundary}
    one, other = (run_transient(entry.template, **task, without=w) for w in ([], ["closed form"]))
    np.testing.assert_array_equal(np.sign(one.y), np.sign(other.y))
    np.testing.assert_allclose(one.y, other.y, atol=2e-3)  # the steps stop where |dx/dt| <= 1e-4


@pytest.mark.parametrize("shape", [(1, 5000), (5000, 3), (1, 1)])
@pytest.mark.parametrize("dtype", BACKENDS)
def test_thin_grids(shape: tuple[int, int], dtype: str) -> None:
    x = states(shape)
    for boundary in BOUNDARIES:
        want = run_transient(NINE, state=x, input=np.sin(9 * x), boundary=boundary, duration=2.0, backend="reference")
        got = run(NINE, x, boundary, dtype, duration=2.0)
        np.testing.assert_allclose(got.x, want.x, atol=1e-12 if dtype == "float64" else 1e-5)
        same(got, run(NINE, x, boundary, dtype, duration=2.0, without=["blocking"]))


@pytest.mark.parametrize("savings", [[], ["sleep"], ["blocking"], ["closed form"]])
@pytest.mark.parametrize("template", [HOLES, NINE, Template(2, [[0, 1, 0], [0, 1, 0], [0, 0, 0]], 0.5, "uncoupled")])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_no_number_is_found(template: Template, savings: list[str], value: float) -> None:
    backend = CpuBackend("float32")
    x = states((40, 150)).astype(np.float32)
    x[17, 130] = value
    plan = make_plan(template, x.shape, ZERO_FLUX, limit=5.0, without=savings)
    with pytest.raises(InputError, match=r"nan|inf"):
        backend.transient(plan, backend.load(x, "lam"), backend.load(np.ones_like(x), "lam"))


def test_a_batch_is_its_grids_one_by_one() -> None:
    x = states((5, 40, 70))
    whole = run(HOLES, x, fixed(-1), duration=5.0)
    for grid, state in zip(whole.x, x, strict=True):
        np.testing.assert_array_equal(grid, run(HOLES, state, fixed(-1), duration=5.0).x)


def test_what_is_switched_off_is_said() -> None:
    plan = make_plan(HOLES, (512, 512), fixed(-1), without=["sleep"])
    assert "no sleep" in plan.explain()
    assert plan.depth == 10
    assert "10 steps a pass" in plan.explain()
    with pytest.raises(InputError, match="without 'magic', which is no saving"):
        make_plan(HOLES, (512, 512), fixed(-1), without=["magic"])
