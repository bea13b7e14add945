"""Tables, terms, cells: their definitions, their sign conventions, the library's templates against ranks and rules."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import InputError, Template, fixed, library, run, run_transient
from cnnsim.characteristic import SIGN, TANH, Cell, Characteristic, parse_cell
from cnnsim.machine import UniversalMachine
from cnnsim.plan import make_plan
from cnnsim.program_file import load_program
from cnnsim.table import Table, from_pairs, lines, parse_table, steps
from cnnsim.term import Term, from_candy, from_matcnn
from tests.oracles import kinds
from tests.oracles.pictures import Case, black, plane

both = pytest.mark.parametrize("backend", ["reference", "cpu"])
RING = np.array([[1.0, 1, 1], [1, 0, 1], [1, 1, 1]])
SHAPES = [(1, 1), (1, 9), (2, 2), (7, 8)]


# --- tables ---------------------------------------------------------------------------------------------------


def by_hand(pairs: list[tuple[float, float]], interpolation: int, v: float) -> float:
    """The printed function, said as the sources say it."""
    if v <= pairs[0][0]:
        return pairs[0][1]
    for (left, low), (right, high) in pairwise(pairs):
        if left < v <= right:
            return high if interpolation == 0 else low + (high - low) * (v - left) / (right - left)
    return pairs[-1][1]


PAIRS = [(-0.95, -0.5), (-0.37, -1.0), (-0.32, 2.0), (0.27, -2.0), (0.95, 0.25)]


@pytest.mark.parametrize("interpolation", [0, 1])
def test_a_printed_function_and_its_mirror_image(interpolation: int) -> None:
    table = from_pairs(interpolation, PAIRS)
    v = np.array([*np.linspace(-2, 2, 81), *(x for x, _ in PAIRS), *(x + 1e-9 for x, _ in PAIRS)])
    wanted = [by_hand(PAIRS, interpolation, x) for x in v]
    assert np.allclose(table(v), wanted, atol=1e-12)
    assert np.allclose(table.mirrored()(-v), wanted, atol=1e-12)
    assert table.mirrored().mirrored() == table


def test_slopes_and_jumps() -> None:
    bell = lines((-2, 0), (-0.3, 0), (0, 1), (0.3, 0), (2, 0))
    v = np.linspace(-1, 1, 200_001)
    numeric = np.diff(v * bell(v)) / np.diff(v)
    assert bell.product_slopes == pytest.approx((numeric.min(), numeric.max()), abs=1e-4)
    assert bell.slopes == pytest.approx((-1 / 0.3, 1 / 0.3))
    assert steps([0, 1], [-1, 1, 4]).jump == 3
    assert lines((0, 0), (1, 2)).jump == 0


@pytest.mark.parametrize(
    "value",
    [
        {"linear": [[0, 0], [0, 1]]},
        {"step": {"at": [0], "values": [1]}},
        {"step": {"at": [0], "values": [1, float("nan")]}},
        {"linear": [[0, 0]], "step": {}},
        {"spline": []},
        {"linear": [[0, "a"]]},
    ],
)
def test_a_wrong_table_says_what_is_wanted(value: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="wanted"):
        parse_table(value)


# --- terms: one sign convention, and those of the sources ------------------------------------------------------


@both
def test_a_difference_is_neighbour_minus_centre(backend: str) -> None:
    picture = np.array([[0.1, 0.5, 0.2]])
    west = Term([[0, 0, 0], [1, 0, 0], [0, 0, 0]], "u_kl - u_ij")
    y = run_transient(Template(0, terms=[west]), state=0 * picture, input=picture, backend=backend).y
    assert np.allclose(y, [[0.0, -0.4, 0.3]], atol=1e-6)


def test_conventions_of_the_sources_agree() -> None:
    """CANDY and MATCNN print ANISO with opposite signs because their differences have opposite signs."""
    cross = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])
    hill, dip = (
        lines((-2, 0), (-0.25, 0), (0, 1), (0.25, 0), (2, 0)),
        lines((-2, 0), (-0.25, 0), (0, -1), (0.25, 0), (2, 0)),
    )
    matcnn, candy = from_matcnn(cross, hill, 122), from_candy(cross, dip, "x-x", "x-x")
    start = np.random.default_rng(0).uniform(-0.5, 0.5, (6, 7))
    ends = [
        run_transient(Template([[1.0]], terms=[term]), state=start, duration=2.0, backend="reference").x
        for term in (matcnn, candy)
    ]
    assert np.abs(ends[0] - ends[1]).max() < 1e-13
    assert str(matcnn.of) == str(candy.of) == "x_kl - x_ij"
    assert str(from_matcnn(cross, hill, 12).of) == "u_kl - x_ij"
    assert str(from_matcnn(cross, hill, 11).of) == "u_kl - u_ij"
    odd = steps([0.01], [0.5, -0.5])
    ours = from_candy(RING, odd, "x-u")
    v = np.array([-0.5, -0.01, 0.0, 0.3])
    assert ours.table is not None
    assert np.array_equal(ours.table(v), odd(-v))
    assert str(from_candy(RING, odd, "u").of) == "u_kl"


@pytest.mark.parametrize("code", [1, 14, 211, "x"])
def test_an_unknown_argument_code_is_named(code: Any) -> None:
    with pytest.raises(InputError, match="code"):
        from_matcnn(RING, lines((0, 0)), code)


@both
def test_weights_that_differ_from_cell_to_cell(backend: str) -> None:
    rng = np.random.default_rng(3)
    weights, x = rng.normal(size=(3, 3, 4, 5)) * 0.2, rng.uniform(-1, 1, (4, 5))
    end = run_transient(
        Template(0, terms=[Term(weights, "y_kl")]), state=x, boundary=fixed(0.5), duration=0.1, step=0.1,
        scheme="euler", backend=backend,
    ).x  # fmt: skip
    around = np.pad(x, 1, constant_values=0.5)
    for i, j in np.ndindex(4, 5):
        assert end[i, j] == pytest.approx(
            0.9 * x[i, j] + 0.1 * (weights[:, :, i, j] * around[i : i + 3, j : j + 3]).sum(), abs=1e-6
        )
    with pytest.raises(InputError, match="weights for"):
        make_plan(Template(0, terms=[Term(weights, "y_kl")]), (5, 5), fixed(0))


def test_plans_of_terms() -> None:
    u_only = Template([[1.0]], terms=[Term(RING, "u_kl - u_ij", lines((-2, 2), (0, 0), (2, 2)))])
    assert make_plan(u_only, (4, 4), fixed(0)).method == "closed form"
    steep = Template([[1.0]], terms=[Term(RING, "y_kl - y_ij", lines((-1, -9), (1, 9)))])
    plan = make_plan(steep, (4, 4), fixed(0))
    assert plan.method == "general"
    assert plan.step == pytest.approx(1 / (1 + 2 * 8 * 9))
    with pytest.raises(InputError, match=r"needs a step below 0\.01379"):
        make_plan(steep, (4, 4), fixed(0), step=0.02)
    jumps = Template([[1.0]], terms=[Term(RING, "u_kl - x_ij", steps([0], [-1, 1]))])
    assert "states swing by about step x jump = 0.2" in make_plan(jumps, (4, 4), fixed(0)).explain()


def test_chatter_is_as_large_as_the_plan_says() -> None:
    """A sign of the state as feedback: Euler swings within step x jump around the surface, not beyond."""
    sliding = Template(0, terms=[Term([[-1.0]], "x_kl", steps([0], [-1, 1]))])
    for h in (0.1, 0.02):
        x = run_transient(sliding, state=[[0.5]], duration=20.0, scheme="euler", step=h, backend="reference").x
        assert 0 < abs(x[0, 0]) <= 2 * h


# --- cells ----------------------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize(
    ("shape", "f"),
    [
        (TANH, np.tanh),
        (Characteristic("tanh", 3), lambda x: np.tanh(3 * x)),
        (Characteristic(slope=5), lambda x: np.clip(5 * x, -1, 1)),
        (SIGN, np.sign),
        (Characteristic("table", table=lines((-2, -1), (1, 0.5))), lambda x: np.interp(x, [-2, 1], [-1, 0.5])),
    ],
)
def test_characteristics(backend: str, shape: Characteristic, f: Any) -> None:
    x = np.linspace(-2, 2, 12).reshape(3, 4)
    task: dict[str, Any] = {"cell": Cell("chua-yang", shape), "scheme": "euler", "step": 0.1, "backend": backend}
    end = run_transient(Template([[0.5]]), state=x, duration=0.1, **task)
    assert np.allclose(end.x, 0.9 * x + 0.05 * f(x), atol=1e-6)
    assert np.allclose(end.y, f(end.x), atol=1e-6)


def test_cells_say_what_they_want() -> None:
    assert parse_cell("discrete-time").output == SIGN
    assert parse_cell({"model": "chua-yang", "characteristic": "tanh", "slope": 2}).output == Characteristic("tanh", 2)
    for wrong in ("spiking", {"model": "full-range", "characteristic": "tanh"}, {"characteristic": "step"}, {"p": 1}):
        with pytest.raises(InputError):
            parse_cell(wrong)
    with pytest.raises(InputError, match="nearest are the time 3"):
        run_transient(Template([[1.0]]), state=[[1.0]], cell="discrete-time", duration=2.6)


# --- discrete time: Harrer and Nossek's theorems ---------------------------------------------------------------


@both
def test_without_feedback_one_step_is_enough(backend: str) -> None:
    rng = np.random.default_rng(1)
    t, u = Template(0, rng.normal(size=(3, 3)), 0.3), rng.uniform(-1, 1, (6, 7))
    result = run_transient(t, state=0 * u, input=u, cell="discrete-time", backend=backend)
    assert result.settled
    assert result.t == 1
    assert np.array_equal(result.y, np.sign(result.y))


@both
@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_symmetric_feedback_ends_in_a_fixed_point_or_a_cycle_of_two(backend: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(3, 3))
    t, x = Template(a + a[::-1, ::-1], z=rng.normal()), rng.choice([-1.0, 1.0], (5, 6))
    task: dict[str, Any] = {"boundary": fixed(-1), "cell": "discrete-time", "backend": backend}
    late = run_transient(t, state=x, duration=60.0, **task).y
    assert np.array_equal(run_transient(t, state=late, duration=2.0, **task).y, late)


@both
def test_a_cycle_of_two_is_not_settled(backend: str) -> None:
    blink = Template([[-1.0]])
    with pytest.raises(InputError, match="has not settled"):
        run_transient(blink, state=[[1.0, -1.0]], cell="discrete-time", backend=backend)


@both
def test_a_drive_of_zero_keeps_the_output(backend: str) -> None:
    nothing = Template(0)
    y = run_transient(nothing, state=[[0.3, -0.2, 0.0]], cell="discrete-time", backend=backend).y
    assert y.tolist() == [[1.0, -1.0, 0.0]]


@both
def test_euler_with_step_one_is_the_discrete_cell(backend: str) -> None:
    rng = np.random.default_rng(4)
    a, b, x, u = rng.normal(size=(3, 3)) * 0.1, rng.normal(size=(3, 3)), *rng.uniform(-1, 1, (2, 5, 6))
    discrete = run_transient(
        Template(a, b), state=x, input=u, duration=4.0, cell=Cell("discrete-time", Characteristic()), backend=backend
    )
    euler = run_transient(Template(a, b), state=x, input=u, duration=4.0, scheme="euler", step=1.0, backend=backend)
    assert np.allclose(discrete.y, euler.y, atol=1e-6)


# --- the library ----------------------------------------------------------------------------------------------

BINARY = [
    "row-histogram", "life-discrete", "life-discrete-1-layer", "discrete-connected-components", "discrete-hole-filler",
    "discrete-edge", "concentric-contour", "discrete-increase", "discrete-decrease",
]  # fmt: skip
GRAY = {
    "average-gradient": 1e-3, "mean-difference": 1e-3, "edge-enhancement": 1e-3, "global-maximum": 1e-2,
    "global-maximum-matcnn": 1e-2, "global-minimum": 1e-2, "gray-dilation": 0.021, "gray-erosion": 0.021,
}  # fmt: skip
DECIDED = [
    "gradient-threshold", "gradient-threshold-bistable", "flat-places", "gray-contour", "local-maxima",
    "local-maxima-matcnn", "local-minima", "gray-line-30-60",
]  # fmt: skip


@both
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", BINARY)
def test_binary_definitions(name: str, shape: tuple[int, int], backend: str) -> None:
    rng = np.random.default_rng([*name.encode(), *shape])
    for share in (0.3, 0.6):
        picture = plane(rng.random(shape) < share)
        answer = kinds.ANSWERS[name](Case(picture, picture))
        assert np.array_equal(np.sign(run(name, picture, backend=backend).y), answer)


@both
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", [*GRAY, *DECIDED])
def test_gray_definitions(name: str, shape: tuple[int, int], backend: str) -> None:
    picture = np.random.default_rng([*name.encode(), *shape]).uniform(-0.9, 0.9, shape)
    y, answer = run(name, picture, backend=backend).y, kinds.ANSWERS[name](Case(picture, picture))
    if name in GRAY:
        assert np.abs(y - answer)[1:-1, 1:-1].max(initial=0) <= GRAY[name]
        at_most = GRAY[name] * (8 if name in ("gray-dilation", "gray-erosion") else 1)  # the border repeats cells
        assert np.abs(y - answer).max() <= at_most
    else:
        assert (y * answer > 0.9).all()


@both
@pytest.mark.parametrize("z", [0, 2, -2, 3, -3])
def test_the_median_and_the_ranks_beside_it(z: int, backend: str) -> None:
    picture = np.random.default_rng(z + 9).uniform(-0.9, 0.9, (9, 10))
    y = run("median", picture, bias=np.full(picture.shape, z), backend=backend).y
    ordered = np.sort(kinds.neighbours(picture, None), axis=0)
    first = {0: 3, 2: 5, -2: 1, 3: 6, -3: 0}[z]
    low, high = ordered[first], ordered[first + 1]
    inside = (slice(1, -1), slice(1, -1))  # the border repeats cells, and jumps are larger there
    assert (y >= low - 0.021)[inside].all()
    assert (y <= high + 0.021)[inside].all()


@pytest.mark.parametrize("name", ["perona-malik", "perona-malik-4"])
def test_anisotropic_diffusion_smooths_and_keeps_the_edge(name: str) -> None:
    rng = np.random.default_rng(5)
    clean = np.where(np.arange(16) < 8, -0.6, 0.6) * np.ones((16, 1))
    y = run(name, clean + rng.normal(0, 0.05, clean.shape)).y
    assert (y - clean).std() < 0.3 * 0.05
    assert (y[:, 8] - y[:, 7]).min() > 1.15


@both
def test_the_wave_arrives_at_the_distance_in_steps(backend: str) -> None:
    rng = np.random.default_rng(6)
    walls = rng.random((12, 13)) < 0.45
    start = np.zeros_like(walls)
    start[tuple(np.argwhere(~walls)[0])] = True
    for count in (1, 3, 8, 20):
        y = run("pathfinder-wave", plane(walls), state=plane(start), duration=count, backend=backend).y
        assert np.array_equal(black(y), kinds.arrival(walls, start, count))


@both
def test_concentric_contour_needs_discrete_time(backend: str) -> None:
    square = -np.ones((11, 11))
    square[1:10, 1:10] = 1
    rings = run("concentric-contour", square, backend=backend).y
    assert np.array_equal(rings[5], [-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1])
    distance = np.hypot(*np.mgrid[-8:9, -8:9])
    disc = np.where(distance < 7.3, 1.0, -1.0)
    rings = run("concentric-contour", disc, backend=backend).y
    smooth = run("concentric-contour", disc, cell="chua-yang", duration=60.0, backend=backend).y
    assert (np.sign(smooth) != rings).sum() > 10


def test_the_library_says_what_is_wrong_with_a_file(tmp_path: Any) -> None:
    good = (library.folder() / "average-gradient.toml").read_text()
    for old, new, message in [
        ("u_kl - u_ij", "u - u", "argument"),
        ("{ linear", "{ cubic", "table"),
        ("of =", "off =", "term 0"),
        ('input = "picture"', 'input = "none"', "reads u"),
    ]:
        (tmp_path / "average-gradient.toml").write_text(good.replace(old, new, 1))
        with pytest.raises(InputError, match=message):
            library.load_file(tmp_path / "average-gradient.toml")


def test_a_term_checks_itself() -> None:
    for wrong in ({"weights": np.ones((2, 2))}, {"of": "w_kl"}, {"delay": -1.0}, {"layer": -1}, {"table": [0, 1]}):
        with pytest.raises(InputError, match="wanted"):
            Term(**{"weights": [[1.0]], **wrong})  # type: ignore[arg-type]  # on purpose
    with pytest.raises(InputError, match="wanted"):
        Table("linear", (1.0, 0.0), (0.0, 0.0))


@both
def test_programs_run_the_new_kinds(backend: str, tmp_path: Any) -> None:
    """Holes filled in discrete time, then the median of the picture, and a sequence that a step cannot have."""
    text = """name = "mixed"
inputs = ["picture"]
outputs = ["filled", "smooth"]
lam = ["picture", "smooth"]
llm = ["filled"]
[[step]]
template = "discrete-hole-filler"
input = "picture"
to = "filled"
[[step]]
template = "median"
input = "picture"
to = "smooth"
"""
    (tmp_path / "mixed.toml").write_text(text)
    rng = np.random.default_rng(8)
    picture = plane(rng.random((9, 9)) < 0.6)
    found = UniversalMachine(backend, "float64").run(load_program(tmp_path / "mixed.toml"), picture=picture)
    assert np.array_equal(plane(found["filled"]), kinds.flood_holes(Case(picture)))
    assert np.allclose(found["smooth"], run("median", picture, backend=backend, dtype="float64").y)
    (tmp_path / "film.toml").write_text(text.replace("median", "slow-motion"))
    with pytest.raises(InputError, match="sequence of pictures"):
        load_program(tmp_path / "film.toml")
    (tmp_path / "waves.toml").write_text(text.replace("median", "autowave"))
    with pytest.raises(InputError, match="has 2 layers"):
        load_program(tmp_path / "waves.toml")
