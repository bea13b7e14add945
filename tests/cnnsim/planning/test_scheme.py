"""Declared orders, stability limits and the closed form, each against an independent answer."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from cnnsim import PERIODIC, InputError, Template, fixed, run_transient
from cnnsim.network import Term
from cnnsim.network.cell import uncoupled_state
from cnnsim.planning.plan import make_plan
from cnnsim.planning.scheme import EULER, RK4, SCHEMES, Scheme
from cnnsim.planning.stability import step_limit


@pytest.mark.parametrize("scheme", list(SCHEMES.values()), ids=list(SCHEMES))
@pytest.mark.parametrize("backend", ["reference", "cpu"])
def test_observed_order_is_the_declared_one(scheme: Scheme, backend: str) -> None:
    """In the linear region x' = M x + z has the answer x = e^(Mt) (x0 + M^-1 z) - M^-1 z, here on a ring of 5 cells."""
    a, z, n = np.array([[0, 0, 0], [0.3, 0.2, -0.4], [0, 0, 0]]), 0.05, 5
    m = -np.eye(n) + sum(a[1, 1 + l] * np.roll(np.eye(n), l, axis=1) for l in (-1, 0, 1))
    x0 = np.array([0.3, -0.2, 0.4, 0.1, -0.3])
    rest = -np.linalg.solve(m, np.full(n, z))
    exact = expm(2 * m) @ (x0 - rest) + rest
    assert np.abs(x0).max() < 0.9  # the trajectory stays where nothing saturates
    errors = []
    for steps in (16, 32, 64):
        end = run_transient(Template(a, z=z), state=x0[None], boundary=PERIODIC, duration=2.0, scheme=scheme.name,
                            step=2 / steps, backend=backend, dtype="float64")  # fmt: skip
        errors.append(np.abs(end.x[0] - exact).max())
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert observed == pytest.approx(scheme.order, abs=0.12)


def test_a_table_that_lies_about_its_order_is_refused() -> None:
    with pytest.raises(ValueError, match="declares order 2"):
        Scheme("wrong", ((), (0.5,)), (0.5, 0.5), order=2)
    with pytest.raises(ValueError, match="declares order 1"):
        Scheme("modest", RK4.a, RK4.b, order=1)


@pytest.mark.parametrize(("a", "limit"), [
    ([[0, 1, 0], [1, -3, 1], [0, 1, 0]], 0.25),
    ([[0, 0, -2, 0, 0], [0, -4, 16, -4, 0], [-2, 16, -39, 16, -2], [0, -4, 16, -4, 0], [0, 0, -2, 0, 0]], 2 / 128),
    ([[2.0]], 2.0),
])  # fmt: skip
def test_limits_of_known_templates(a: list[list[float]], limit: float) -> None:
    assert step_limit(Template(a), fixed(0), "settled", EULER) == pytest.approx(limit, rel=1e-3)


def test_the_laplacian_is_stable_below_its_limit_and_not_above() -> None:
    rng = np.random.default_rng(0)
    t = Template([[0, 1, 0], [1, -3, 1], [0, 1, 0]])
    x = rng.uniform(-0.1, 0.1, (16, 16))
    calm = run_transient(t, state=x, boundary=PERIODIC, duration=20.0, step=0.24, scheme="euler")
    assert np.ptp(calm.x) < np.ptp(x) / 5
    with pytest.raises(InputError, match=r"step 0.26 cannot be stable: euler .* below 0.25"):
        run_transient(t, state=x, boundary=PERIODIC, duration=20.0, step=0.26, scheme="euler")


def test_a_one_sided_template_is_not_held_to_the_limit_of_its_torus() -> None:
    one_sided = Template([[0, 0, 0], [-3, 0, 0], [0, 0, 0]])
    assert step_limit(one_sided, fixed(0), "settled", EULER) == pytest.approx(2.0)
    assert step_limit(one_sided, PERIODIC, "settled", EULER) < 0.5  # its modes turn: -1 - 3 exp(i p)


@pytest.mark.parametrize("a", [-2.0, 0.0, 0.5, 1.0, 1 + 1e-7, 2.0, 3.0])
@pytest.mark.parametrize("t", [0.0, 0.3, 6.0])
def test_closed_form_is_the_integral(a: float, t: float) -> None:
    """Cell by cell against DOP853 restarted at each kink, which is where its error estimate would fail."""
    rng = np.random.default_rng(3)
    x0, s = rng.uniform(-4, 4, 12), rng.uniform(-4, 4, 12)
    ours = uncoupled_state(x0, s, a, t, "chua-yang")
    kick = 2e-9 * np.exp(max(0.0, (a - 1) * t))  # the oracle steps 1e-9 over each kink, and a > 1 lets that grow
    for i in range(12):
        assert ours[i] == pytest.approx(_integrated(x0[i], s[i], a, t), abs=1e-8 + kick)


def _integrated(x: float, s: float, a: float, t: float) -> float:
    def kink(_t: float, y: np.ndarray) -> float:
        return float(abs(y[0]) - 1)

    kink.terminal = True  # type: ignore[attr-defined]  # scipy's interface for a terminal event
    now = 0.0
    while now < t:
        piece = np.clip(x + 1e-9 * np.sign(-x + a * np.clip(x, -1, 1) + s), -1e9, 1e9)
        side = 0 if abs(piece) <= 1 else np.sign(piece)

        def rate(_t: float, y: np.ndarray, side: float = side) -> np.ndarray:
            return -y + a * (y if side == 0 else side) + s

        run = solve_ivp(rate, (now, t), [piece], method="DOP853", rtol=1e-11, atol=1e-12, events=kink)
        now, x = float(run.t[-1]), float(run.y[0, -1])
    return x


@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
@pytest.mark.parametrize("a", [0.0, 0.7, 1.0, 2.5])
@pytest.mark.parametrize("backend", ["reference", "cpu"])
def test_closed_form_is_what_stepping_tends_to(cell: str, a: float, backend: str) -> None:
    rng = np.random.default_rng(5)
    t = Template([[a]], rng.normal(size=(3, 3)), 0.1)
    x, u = rng.uniform(-1, 1, (9, 8)), rng.uniform(-1, 1, (9, 8))
    task = {"state": x, "input": u, "duration": 3.0, "cell": cell, "backend": backend, "dtype": "float64"}
    exact = run_transient(t, **task)  # type: ignore[arg-type]  # a dict of mixed values
    assert exact.plan.method == "closed form"
    stepped = run_transient(t, **task, scheme="rk4", step=0.005)  # type: ignore[arg-type]  # the same
    assert np.abs(exact.x - stepped.x).max() < 3e-3 * (1 + np.exp((a - 1) * 3))
    assert np.abs(exact.y - stepped.y).max() < 2e-3 * (1 + np.exp((a - 1) * 3))


@pytest.mark.parametrize("a", [-1.0, 0.0, 0.9, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
def test_closed_form_at_rest_is_its_own_limit(a: float, cell: str) -> None:
    rng = np.random.default_rng(1)
    x, s = rng.uniform(-1, 1, 100), rng.uniform(-3, 3, 100)
    late, rest = (uncoupled_state(x, s, a, t, cell) for t in (1e6, np.inf))  # type: ignore[arg-type]  # cell is one of two
    assert rest == pytest.approx(late, abs=1e-9)


def test_final_output_rule_of_uncoupled_cells() -> None:
    """a > 1: sign((a-1) x0 + s) if |s| < a - 1, else sign(s); a = 1: sign(s); a < 1: clip(s / (1 - a))."""
    rng = np.random.default_rng(2)
    x, s = rng.uniform(-1, 1, 500), rng.uniform(-3, 3, 500)
    for a in (1.0, 2.0, 3.5):
        end = np.clip(uncoupled_state(x, s, a, np.inf, "chua-yang"), -1, 1)
        assert np.array_equal(end, np.sign(np.where(np.abs(s) < a - 1, (a - 1) * x + s, s)))
    end = np.clip(uncoupled_state(x, s, 0.25, np.inf, "chua-yang"), -1, 1)
    assert end == pytest.approx(np.clip(s / 0.75, -1, 1))


def test_ties_and_limits_give_numbers() -> None:
    x = np.array([0.0, 1.0, -1.0, 0.5, 0.0])
    for a in (0.0, 1.0, 2.0):
        for s in (0.0, 1.0, -1.0, 1 - a):
            for t in (0.0, 1.0, np.inf):
                assert np.isfinite(uncoupled_state(x, np.full(5, s), a, t, "chua-yang")).all()


@pytest.mark.parametrize(("x", "s", "a"), [(-1.0, 1 + 2e-16, 0.0), (-1.0, 0.5 + 2e-16, 0.5), (0.0, 5e-324, 2.0)])
@pytest.mark.parametrize("backend", ["reference", "cpu"])
def test_next_to_a_tie_there_is_an_end(x: float, s: float, a: float, backend: str) -> None:
    end = run_transient(Template(a, z=s), state=[[x, -x]], bias=[[0.0, -2 * s]], backend=backend, dtype="float64").x
    assert end == pytest.approx(np.array([[a + s, -a - s]]), rel=1e-15)


def test_adaptive_needs_a_duration_and_the_reference() -> None:
    t, x = Template(np.full((3, 3), 0.1)), np.zeros((2, 2))
    with pytest.raises(InputError, match="not until settled"):
        run_transient(t, state=x, scheme="adaptive", backend="reference")
    with pytest.raises(InputError, match="runs on the reference backend"):
        run_transient(t, state=x, scheme="adaptive", duration=1.0, backend="cpu")


@pytest.mark.parametrize(("arguments", "message"), [
    ({"duration": -1.0}, "duration -1.0"),
    ({"duration": float("nan")}, "duration nan"),
    ({"limit": -1.0}, "limit -1.0"),
    ({"limit": float("nan")}, "limit nan"),
    ({"limit": float("inf")}, "limit inf"),
    ({"step": 0.0}, "step 0.0"),
    ({"scheme": "leapfrog"}, "known are euler, exponential-euler, heun, rk4, adaptive"),
    ({"scheme": "eulr"}, "rk4, adaptive; did you mean 'euler'"),
    ({"cell": "full_range"}, "discrete-time; did you mean 'full-range'"),
    ({"cell": "spiking"}, "known are chua-yang, full-range"),
    ({"without": ["sleeping"]}, "names of savings wanted: closed form"),
])  # fmt: skip
def test_bad_requests_are_told_what_is_wanted(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_plan(Template(np.ones((3, 3))), (4, 4), fixed(0), **arguments)  # type: ignore[arg-type]  # on purpose


@pytest.mark.parametrize("duration", [1e-300, 1e-12])
@pytest.mark.parametrize("terms", [(), (Term(0.5, "x_kl"),)], ids=["stepped", "general"])
def test_a_time_far_shorter_than_a_step_is_one_step(duration: float, terms: tuple[Term, ...]) -> None:
    plan = make_plan(Template(np.ones((3, 3)), terms=terms), (2, 3), fixed(0), duration=duration)
    assert (plan.steps, plan.step) == (1, duration)
