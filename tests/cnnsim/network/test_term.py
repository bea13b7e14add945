"""Tables, terms and cells: their definitions and their sign conventions."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cnnsim import InputError, Template, fixed, run_transient
from cnnsim.formats.candy.terms import from_candy
from cnnsim.formats.matcnn import from_matcnn
from cnnsim.network import Cell, Characteristic, Term
from cnnsim.network.characteristic import SIGN, TANH, parse_cell
from cnnsim.network.table import from_pairs, lines, parse_table, steps
from cnnsim.planning.plan import make_plan

both = pytest.mark.parametrize("backend", ["reference", "cpu"])

RING = np.array([[1.0, 1, 1], [1, 0, 1], [1, 1, 1]])


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
