"""Templates and boundaries check themselves and say what they are."""

import itertools
from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Boundary, Frames, InputError, Sides, Template, fixed, run, run_transient
from cnnsim.network import Tap, pad, parse_boundary
from cnnsim.network.sides import parse_run_boundary


@pytest.mark.parametrize(("a", "message"), [
    ([[1, 2], [3, 4]], "2 x 2, an odd square"),
    ([[1, 2, 3]], "1 x 3, an odd square"),
    (np.zeros((13, 13)), "radius 6, at most 5"),
    ([[0, 0, 0], [0, np.nan, 0], [0, 0, 0]], r"nan in row 2, column 2"),
    ([[0, 0, 0], [0, 1, np.inf], [0, 0, 0]], "inf in row 2, column 3"),
    ([[1, 2, 3], [4, 5], [6, 7, 8]], "no rectangular matrix of numbers: row 2 has 2 entries, row 1 has 3"),
    ([["x"] * 11] * 11, r"no rectangular matrix of numbers: .{100,130} \.\.\.$"),
    ([["a"]], "no rectangular matrix"),
])  # fmt: skip
def test_a_bad_matrix_is_refused(a: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Template(a, name="bad")


@pytest.mark.parametrize("z", [np.nan, np.inf, "1", None, True])
def test_a_bad_bias_is_refused(z: Any) -> None:
    with pytest.raises(InputError, match=r"z is .* a finite number wanted"):
        Template([[1]], z=z)


def test_a_template_cannot_be_changed_afterwards() -> None:
    numbers = np.eye(3)
    t = Template(numbers)
    numbers[0, 0] = 5
    assert t.A[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        t.A[0, 0] = 2


def test_taps_are_the_entries_that_are_not_zero() -> None:
    t = Template([[0, 2, 0], [0, 1, 0], [0, 0, -3]], np.zeros((5, 5)))
    assert t.feedback_taps == (Tap(-1, 0, 2), Tap(0, 0, 1), Tap(1, 1, -3))
    assert t.control_taps == ()
    assert (t.radius, t.self_feedback, t.uncoupled, t.symmetric, t.isotropic) == (1, 1, False, False, False)
    assert Template([[0, 1, 0], [1, 3, 1], [0, 1, 0]]).isotropic
    assert Template([[0, 1, 0], [0, 3, 0], [0, 1, 0]]).symmetric
    assert not Template([[0, 1, 0], [0, 3, 0], [0, 1, 0]]).isotropic
    assert Template(np.diag([0, 0, 2, 0, 0])).uncoupled


def _folded(i: int, n: int) -> int:
    """Walk from cell 0 and turn back at each end."""
    at, way = 0, 1
    for _ in range(abs(i)):
        if not 0 <= at + way < n:
            way = -way
        at += way if n > 1 else 0
    return at


def _brute_pad(plane: np.ndarray, r: int, boundary: Boundary, constant: float) -> np.ndarray:
    rows, cols = plane.shape
    out = np.empty((rows + 2 * r, cols + 2 * r))
    for i in range(-r, rows + r):
        for j in range(-r, cols + r):
            if boundary.kind == "periodic":
                out[i + r, j + r] = plane[i % rows, j % cols]
            elif boundary.kind == "reflecting":
                out[i + r, j + r] = plane[_folded(i, rows), _folded(j, cols)]
            elif boundary.kind == "zero-flux":
                out[i + r, j + r] = plane[min(max(i, 0), rows - 1), min(max(j, 0), cols - 1)]
            else:
                out[i + r, j + r] = plane[i, j] if 0 <= i < rows and 0 <= j < cols else constant
    return out


@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC, fixed(0.5), Boundary("reflecting")], ids=str)
def test_virtual_cells(boundary: Boundary) -> None:
    for shape, r in itertools.product([(1, 1), (1, 4), (3, 2), (7, 5)], [1, 2, 5]):
        plane = np.random.default_rng(0).normal(size=shape)
        assert np.array_equal(pad(plane, r, boundary, 0.5), _brute_pad(plane, r, boundary, 0.5)), (shape, r)


@pytest.mark.parametrize(("backend", "boundary"), [
    *((backend, boundary) for backend in ("reference", "cpu")
      for boundary in (ZERO_FLUX, PERIODIC, fixed(-1.0, 0.25), fixed(0.5, -3.0))),
    ("reference", Boundary("reflecting")),
], ids=str)  # fmt: skip
def test_one_euler_step_is_the_equation_written_out(backend: str, boundary: Boundary) -> None:
    """x + h (-x + A*y + B*u + z), summed cell by cell in plain loops; grids smaller than the radius included."""
    for shape in [(1, 1), (1, 7), (6, 1), (2, 3), (9, 8)]:
        for r, s in [(1, 1), (5, 2), (1, 5)]:
            _check_euler_step(backend, boundary, shape, r, s)


def _check_euler_step(backend: str, boundary: Boundary, shape: tuple[int, int], r: int, s: int) -> None:
    rng = np.random.default_rng(4)
    t = Template(rng.normal(size=(2 * r + 1,) * 2) / (2 * r + 1) ** 2, rng.normal(size=(2 * s + 1,) * 2), 0.3)
    x, u, h = rng.uniform(-2, 2, shape), rng.uniform(-1, 1, shape), 0.25
    y = _brute_pad(np.clip(x, -1, 1), r, boundary, boundary.y)
    v = _brute_pad(u, s, boundary, boundary.u)
    expected = np.empty(shape)
    for i, j in np.ndindex(shape):
        total = t.z
        for k, l in np.ndindex(t.A.shape):
            total += t.A[k, l] * y[i + k, j + l]
        for k, l in np.ndindex(t.B.shape):
            total += t.B[k, l] * v[i + k, j + l]
        expected[i, j] = x[i, j] + h * (total - x[i, j])
    end = run_transient(t, state=x, input=u, boundary=boundary, duration=h, scheme="euler", step=h, backend=backend,
                        dtype="float64")  # fmt: skip
    assert end.x == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("text", "boundary"), [
    ("zero-flux", ZERO_FLUX), ("periodic", PERIODIC), ("fixed:-1", fixed(-1)), ("fixed:1,-0.5", fixed(1, -0.5)),
    ("reflecting", Boundary("reflecting")), ("fixed:0,2.5", fixed(0, 2.5)),
    ({"fixed": 0}, fixed(0)), ({"fixed": {"x": 1, "u": -1}}, fixed(1, -1)),
])  # fmt: skip
def test_boundaries_as_people_write_them(text: Any, boundary: Boundary) -> None:
    assert parse_boundary(text) == boundary


@pytest.mark.parametrize(
    "text", ["wrap", "fixed:x", "fixed:1,2,3", {"fixed": "a"}, {"fixed": {"x": 1}}, 3, {"fixed": 2}, "fixed:nan"]
)
def test_a_bad_boundary_is_refused(text: Any) -> None:
    with pytest.raises(InputError, match="boundary"):
        parse_boundary(text)


@pytest.mark.parametrize(("planes", "message"), [
    ({"state": np.ones((2, 2)), "input": np.ones((2, 3))}, r"input has shape \(2, 3\), the state has \(2, 2\)"),
    ({"state": np.ones(4)}, r"state has shape \(4,\)"),
    ({"state": np.ones((0, 3))}, "at least one cell"),
    ({"state": [[1, 2], [3]]}, "no rectangular array"),
    ({"state": np.ones((2, 2))}, "needs an input plane"),
    ({"state": 2 * np.ones((2, 2)), "input": np.ones((2, 2)), "cell": "full-range"}, "state reaches 2"),
])  # fmt: skip
def test_planes_that_do_not_fit_are_told_why(planes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        run_transient(Template([[1]], [[1]]), **planes)


def test_a_network_that_never_settles_says_so_and_keeps_its_result() -> None:
    """Two cells with opposite-sign coupling s > a - 1 oscillate (Zou and Nossek 1991)."""
    from cnnsim import NotSettledError

    t = Template([[0.0, 0, 0], [-1.2, 2, 1.2], [0.0, 0, 0]])
    task: dict[str, Any] = {"state": [[0.1, 0.0]], "boundary": fixed(0)}
    with pytest.raises(NotSettledError, match="has not settled after 50 time constants") as caught:
        run_transient(t, **task, limit=50.0)
    assert caught.value.result.t == pytest.approx(50)
    assert not caught.value.result.settled
    calm = Template([[0.0, 0, 0], [-0.9, 2, 0.9], [0.0, 0, 0]])
    assert run_transient(calm, **task, limit=200.0).settled


@pytest.mark.parametrize(("backend", "dtype", "tolerance"), [
    ("reference", "float64", 1e-12), ("cpu", "float32", 1e-5), ("opencl", "float32", 1e-5),
])  # fmt: skip
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (6, 4)])
def test_a_value_for_each_side_is_a_ring_of_held_cells(
    backend: str, dtype: Any, tolerance: float, shape: tuple[int, int]
) -> None:
    rng, (rows, cols), r = np.random.default_rng(3), shape, 2
    template = Template(rng.normal(size=(3, 3)) / 3, rng.normal(size=(5, 5)) / 5, 0.2)
    x, u, bias = rng.uniform(-1, 1, (3, *shape))
    ring = np.full((rows + 2 * r, cols + 2 * r), np.nan)
    ring[:, :r], ring[:, -r:] = -0.25, 0.5
    ring[:r], ring[-r:] = 1, -1  # the corners belong to the top and the bottom
    inner = np.s_[r:-r, r:-r]
    mask, state, input_, biases = np.ones_like(ring), ring.copy(), ring.copy(), np.zeros_like(ring)
    mask[inner], state[inner], input_[inner], biases[inner] = -1, x, u, bias
    held = run_transient(template, state=state, input=input_, bias=biases, mask=mask, boundary=fixed(0), duration=3.0,
                         scheme="euler", step=0.1, backend="reference", dtype="float64")  # fmt: skip
    for planes in ({"bias": bias}, {"bias": Frames([bias, bias], 1.0)}):
        end = run_transient(template, state=x, input=u, boundary=Sides(1, 0.5, -1, -0.25), duration=3.0, scheme="euler",
                            step=0.1, backend=backend, dtype=dtype, **planes)  # fmt: skip
        assert np.abs(end.x - held.x[inner]).max() < tolerance


def test_sides_are_numbers_from_minus_one_to_one_of_a_linear_template() -> None:
    assert parse_run_boundary("sides:1,-1,0,0.5") == Sides(1, -1, 0, 0.5)
    assert parse_run_boundary("periodic") == PERIODIC
    for text, message in (("sides:1,2,0,0", "boundary value of the right is 2"), ("sides:1,0", "four numbers wanted"),
                          ("sides:a,b,c,d", "four numbers wanted")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            parse_run_boundary(text)
    with pytest.raises(InputError, match="has layers or terms"):
        run("perona-malik", np.zeros((3, 3)), boundary=Sides(0, 0, 0, 1))


def test_a_reflecting_boundary_on_other_backends_is_right_or_refused() -> None:
    reflecting, picture = Boundary("reflecting"), np.random.default_rng(1).uniform(-1, 1, (5, 6))
    blur = Template(np.full((3, 3), 0.1), 0.5)
    with pytest.raises(InputError, match="a reflecting boundary on a compiled backend; backend = 'reference' wanted"):
        run_transient(blur, state=picture, input=picture, boundary=reflecting)
    end = run_transient(blur, state=picture, input=picture, boundary=reflecting, backend="reference")
    padded = _brute_pad(end.y, 1, reflecting, 0.0)
    drive = 0.1 * sum(padded[k : k + 5, l : l + 6] for k, l in np.ndindex(3, 3)) + 0.5 * picture
    assert np.abs(drive - end.x).max() < 1e-2  # settled
    uncoupled = Template(2, np.arange(9.0).reshape(3, 3) / 9 - 0.4, 0.1)
    ours, theirs = (
        run_transient(uncoupled, state=picture, input=picture, boundary=reflecting, backend=name, duration=2.0).x
        for name in ("reference", "cpu")
    )
    assert np.abs(ours - theirs).max() < 1e-5
