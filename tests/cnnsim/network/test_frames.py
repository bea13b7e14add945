"""Delays and sequences: exact against closed forms, and what the library's templates of moving pictures promise."""

import math
from typing import Any

import numpy as np
import pytest

from cnnsim import InputError, Template, fixed, library, run, run_transient
from cnnsim.network import Frames, Term
from cnnsim.network.table import lines
from cnnsim.planning.plan import make_plan

both = pytest.mark.parametrize("backend", ["reference", "cpu"])
FINE: dict[str, Any] = {"dtype": "float64"}


@both
def test_a_delayed_input_is_followed_exactly(backend: str) -> None:
    """Exponential Euler is exact while the drive stands still: x' = -x + u(t - 1)."""
    u = Frames([np.full((2, 2), value) for value in (1.0, -0.5, 0.25)], 0.7)
    t = Template(0, terms=[Term([[1.0]], "u_kl", delay=1.0)])
    x = 0.2
    for value, until, start in ((1.0, 1.7, 0.0), (-0.5, 2.4, 1.7), (0.25, 3.5, 2.4)):
        x = value + (x - value) * np.exp(-(until - start))
    end = run_transient(t, state=np.full((2, 2), 0.2), input=u, duration=3.5, scheme="exponential-euler",
                        backend=backend, dtype="float64").x  # fmt: skip
    assert np.abs(end - x).max() < 1e-13


@both
def test_delayed_feedback_by_the_method_of_steps(backend: str) -> None:
    """x' = -x - b x(t - 1), x = 1 before 0: -b + (1 + b) e^-t, then one variation of constants more."""
    b = 0.6
    t = Template(0, terms=[Term([[-b]], "x_kl", delay=1.0)])
    first = -b + (1 + b) * np.exp(-1.0)
    s = 1.0  # x(1 + s) = first e^-s - b int_0^s e^-(s - r) (-b + (1 + b) e^-r) dr
    second = first * np.exp(-s) + b * b * (1 - np.exp(-s)) - b * (1 + b) * s * np.exp(-s)
    errors = []
    for h in (0.02, 0.01):
        x = run_transient(t, state=[[1.0]], duration=2.0, scheme="heun", step=h, backend=backend, dtype="float64").x
        errors.append(abs(x[0, 0] - second))
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


@both
def test_a_bias_that_changes_with_time(backend: str) -> None:
    bias = Frames([np.full((1, 3), 0.5), np.full((1, 3), -0.25)], 1.0)
    end = run_transient(Template(0), state=np.zeros((1, 3)), bias=bias, duration=2.0, scheme="exponential-euler",
                        backend=backend, dtype="float64").x  # fmt: skip
    middle = 0.5 * (1 - np.exp(-1))
    assert np.abs(end - (-0.25 + (middle + 0.25) * np.exp(-1))).max() < 1e-14


def test_nothing_is_interpolated() -> None:
    t = Template(0, terms=[Term([[1.0]], "y_kl", delay=1.0)])
    assert make_plan(t, (2, 2), fixed(0), duration=2.5).step == pytest.approx(0.1)
    assert make_plan(t, (2, 2), fixed(0), duration=2.0, periods=[0.3]).step == pytest.approx(0.1)
    assert make_plan(Template(0, terms=[Term([[1.0]], delay=0.55)]), (2, 2), fixed(0), duration=1.1).step == 0.55 / 6
    with pytest.raises(InputError, match=r"3\.33333 steps of 0\.3.* the time 0\.9 or the step 0\.333333"):
        make_plan(t, (2, 2), fixed(0), duration=3.0, step=0.3)
    with pytest.raises(InputError, match="use euler or heun"):
        make_plan(t, (2, 2), fixed(0), duration=3.0, scheme="rk4")
    with pytest.raises(InputError, match="give a duration"):
        make_plan(t, (2, 2), fixed(0))
    with pytest.raises(InputError, match="no common step"):
        make_plan(t, (2, 2), fixed(0), duration=math.e)
    steep = Template([[0.0, 1e308, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]], terms=[Term([[1.0]], "y_kl", delay=1.0)])
    with pytest.raises(InputError, match=r"5 time constants in steps of .*; at most 1e\+\d+ steps wanted"):
        make_plan(steep, (2, 2), fixed(0), duration=5.0)
    with pytest.raises(InputError, match="every"):
        Frames([np.ones((2, 2))], 0.0)


@both
def test_a_delayed_non_linear_difference_looks_back_as_a_whole(backend: str) -> None:
    """f(y_kl - u_ij) one step ago: both the neighbour and the centre are the earlier ones."""
    u = Frames([np.array([[0.1, 0.4]]), np.array([[-0.3, 0.8]]), np.array([[0.9, 0.0]])], 1.0)
    t = Template(0, terms=[Term([[0, 0, 0], [0, 0, 1], [0, 0, 0]], "y_kl - u_ij", lines((-2, -1), (2, 1)), delay=1.0)])
    x = [np.array([[0.5, -0.5]])]
    for k in range(3):
        past, then = x[max(0, k - 1)], u.planes[max(0, k - 1)]
        neighbour = np.array([[past[0, 1], 0.2]])
        x.append((np.clip(neighbour, -1, 1) - then) / 2)
    end = run_transient(t, state=x[0], input=u, boundary=fixed(0.2), duration=3.0, scheme="euler", step=1.0,
                        backend=backend, dtype="float64").x  # fmt: skip
    assert np.abs(end - x[3]).max() < 1e-14


# --- the library ----------------------------------------------------------------------------------------------


def moving(speed: int, frames: int = 5, cols: int = 24, at: int = 2, size: tuple[int, int] = (4, 5)) -> np.ndarray:
    film = -np.ones((frames, 8, cols))
    for k in range(frames):
        left = at + speed * k
        film[k, 2 : 2 + size[0], left : left + size[1]] = 1
    return film


@both
def test_motion_to_the_right_is_kept_whole(backend: str) -> None:
    right, rest = run("motion-right", moving(1), backend=backend).y, run("motion-right", moving(0), backend=backend).y
    left = run("motion-right", moving(-1, at=12), backend=backend).y
    assert [int((y > 0).sum()) for y in (right, rest, left)] == [20, 16, 12]


@both
def test_fast_objects_vanish(backend: str) -> None:
    found = [int((run("slow-motion", moving(speed), backend=backend).y > 0).sum()) for speed in (0, 1, 2, 4)]
    assert found[0] == 20
    assert found[3] == 0
    assert found == sorted(found, reverse=True)


@both
def test_the_leading_edge_and_no_noise(backend: str) -> None:
    found = [int((run("moving-parts", moving(speed, 2), backend=backend).y > 0).sum()) for speed in (0, 1, 2)]
    assert found == [0, 2, 8]
    dots = -np.ones((2, 7, 7))
    dots[1, 3, 3] = 1
    assert not (run("moving-parts", dots, backend=backend).y > 0).any()


@both
def test_crossings_of_the_grid_illusion_are_grayer(backend: str) -> None:
    entry = library.load("herring-grid")
    picture = entry.examples[0].input
    assert picture is not None
    y = run("herring-grid", picture, backend=backend).y
    assert y[3:5, 3:5].min() > y[3:5, 6].max() + 0.1


@pytest.mark.parametrize("order", [1, -1])
def test_planes_of_unequal_shape_are_refused_with_both(order: int) -> None:
    """Nobody noticed until a run, and in a place where the planes were no longer counted."""
    with pytest.raises(InputError, match=r"plane 0 has shape \([83], [83]\), plane 1 \([83], [83]\); one shape wanted"):
        Frames([np.zeros((8, 8)), np.zeros((3, 3))][::order], 1.0)
    with pytest.raises(InputError, match=r"plane 2 has shape .*plane 3"):
        Frames([0.0, np.zeros((3, 3)), np.zeros((2, 3, 3)), np.zeros((2, 3, 4))], 1.0)
    assert len(Frames([0.5, np.zeros((3, 3)), np.zeros((2, 3, 3))], 1.0).planes) == 3  # for all cells, for all layers


ANY: Any = 5


@pytest.mark.parametrize(
    ("planes", "message"),
    [
        (ANY, "a sequence of planes 5; a list of them wanted"),
        ("abc", "a sequence of planes 'abc'"),
        ({"a": 1}, "a sequence of planes {'a': 1}"),
        (Frames([np.zeros((2, 2))], 1.0), "a sequence of planes Frames"),
        ([[[1], [1, 2]]], r"plane 0 is no rectangular .* entry 0 has shape \(1,\), entry 1 \(2,\)"),
    ],
)
def test_what_is_no_sequence_of_planes(planes: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Frames(planes, 1.0)


def test_a_sequence_says_its_size_and_not_its_numbers() -> None:
    plane = np.zeros((40, 50))
    assert repr(Frames([plane, plane], 0.5)) == "Frames(2 planes of 40 x 50, a new one every 0.5 time constants)"
    assert repr(Frames([[[1.0, 0.0]]], 2)) == "Frames(1 plane of 1 x 2, a new one every 2 time constants)"
