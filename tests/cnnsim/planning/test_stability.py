"""Modes that turn while they decay: the limit against matrix powers, and the scheme that is chosen for them."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest

from cnnsim import (
    PERIODIC,
    ZERO_FLUX,
    Boundary,
    InputError,
    LayeredTemplate,
    Template,
    Term,
    fixed,
    library,
    run_transient,
)
from cnnsim.planning.plan import make_plan
from cnnsim.planning.scheme import EULER, SCHEMES, Scheme
from cnnsim.planning.stability import limit_of, step_limit
from cnnsim.support import Floats
from cnnsim.support.notices import Notices

TURNING = [[0, 0, 0], [-3, 0, 3], [0, 0, 0]]
"""Not symmetric: the modes of a row are -1 + 6 i cos(...)."""


@cache
def exact_end(A: tuple[tuple[float, ...], ...], state: bytes, shape: tuple[int, int], duration: float) -> Floats:
    """Where a state ends by scipy's DOP853: once for a template and for a term of the same weights."""
    start = np.frombuffer(state).reshape(shape)
    given: dict[str, Any] = {"boundary": fixed(0), "duration": duration, "scheme": "adaptive", "backend": "reference"}
    return run_transient(Template(A), state=start, **given).x


def exact(A: Sequence[Sequence[float]], x: Floats, duration: float) -> Floats:
    return exact_end(tuple(map(tuple, A)), x.tobytes(), x.shape, duration)


def growth(scheme: Scheme, matrix: np.ndarray, h: float) -> float:
    """The largest modulus of an eigenvalue of one step, from the scheme's own table."""
    g = scheme.gain(h) * matrix
    stages = [np.eye(len(matrix))]
    for row in scheme.a[1:]:
        stages.append(np.eye(len(matrix)) + g @ sum(a * k for a, k in zip(row, stages, strict=False)))
    step = np.eye(len(matrix)) + g @ sum(b * k for b, k in zip(scheme.b, stages, strict=True))
    return float(np.abs(np.linalg.eigvals(step)).max())


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=str)
def test_the_limit_is_where_a_step_begins_to_grow(scheme: Scheme) -> None:
    n = 16
    matrix = 3 * (np.eye(n, k=1) - np.eye(n, k=-1)) - np.eye(n)
    limit = step_limit(Template(TURNING), fixed(0), "settled", scheme)
    assert growth(scheme, matrix, 0.99 * limit) < 1 < growth(scheme, matrix, 1.01 * limit)


@pytest.mark.parametrize("backend", ["reference", "cpu"])
@pytest.mark.parametrize("template", [Template(TURNING), Template([[0.0]], terms=[Term(TURNING)])], ids=["A", "term"])
def test_the_plan_follows_what_turns_and_decays(template: Template, backend: str) -> None:
    x = np.random.default_rng(0).uniform(-0.3, 0.3, (16, 16))
    plan = make_plan(template, x.shape, fixed(0), duration=30.0)
    assert plan.scheme is not None
    assert plan.scheme.name == "rk4"
    for scheme in (None, *SCHEMES):
        end = run_transient(template, state=x, boundary=fixed(0), duration=30.0, backend=backend, scheme=scheme)
        assert np.abs(end.x).max() < 1e-6
    if template.terms:
        return
    with pytest.raises(InputError, match=r"euler on this template needs a step below 0\.0[56]"):
        run_transient(template, state=x, boundary=fixed(0), duration=30.0, scheme="euler", step=0.08)


def test_a_step_of_terms_that_may_be_unstable_is_forced_by_naming_the_scheme(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Notices, "_given", set())
    template, x = Template([[0.0]], terms=[Term(TURNING)]), np.full((4, 4), 0.1)
    given: dict[str, Any] = {"state": x, "boundary": fixed(0), "duration": 0.8}
    with pytest.raises(InputError, match=r"rk4 on this template needs a step below .*; name the scheme as well"):
        run_transient(template, **given, step=0.8)
    with pytest.warns(
        RuntimeWarning, match=r"step 0.4 may be unstable: euler on this template is certainly stable"
    ) as w:
        for _ in range(2):
            run_transient(template, **given, scheme="euler", step=0.4)
    assert len(w) == 1


@pytest.mark.parametrize("boundary", [fixed(0), PERIODIC])
def test_two_layers_that_turn(boundary: Boundary) -> None:
    """x' = -x + 0.5 x - 4 v, v' = -v + 0.5 v + 4 x: decays at 0.5 while it turns at 4."""
    other = [Term([[-4.0]], layer=1), Term([[4.0]], layer=0)]
    network = LayeredTemplate([Template([[0.5]], terms=[term]) for term in other])
    x = np.random.default_rng(1).uniform(-0.05, 0.05, (2, 6, 7))
    end = run_transient(network, state=x, boundary=boundary, duration=20.0)
    assert np.abs(end.x).max() < 1e-5
    with pytest.raises(InputError, match="needs a step below"):
        run_transient(network, state=x, boundary=boundary, duration=20.0, step=0.8)


def test_a_mode_that_hardly_decays_does_not_forbid_a_short_run() -> None:
    template = Template([[0.0, 0.0, 0.0], [-1.0, 0.99, 1.0], [0.0, 0.0, 0.0]])
    long, short = (step_limit(template, fixed(0), duration, EULER) for duration in ("settled", 2.0))
    assert long < 0.01 < 0.1 < short


def test_a_mode_that_stands_still_limits_nothing() -> None:
    """Modes of +-1e-9 i, and the mode -1 of the saturated cells."""
    assert limit_of(np.array([-1e-9 + 1e-9j, -1.0]), "settled", EULER) == pytest.approx(2.0)


@pytest.mark.parametrize("seed", range(3))
def test_strong_oscillations_are_followed_not_only_kept_stable(seed: int) -> None:
    """Random antisymmetric templates of size 12 without a step asked for, against steps of 0.002 in float64."""
    random = np.random.default_rng(seed)
    weights = random.uniform(-1, 1, (3, 3))
    weights -= weights[::-1, ::-1]
    template = Template(12 / np.abs(weights).sum() * weights)
    state = random.uniform(-0.05, 0.05, (16, 16))
    found = run_transient(template, state=state, boundary=PERIODIC, duration=4.0)
    exact = run_transient(
        template, state=state, boundary=PERIODIC, duration=4.0, scheme="rk4", step=0.002, dtype="float64"
    )
    assert np.abs(found.x - exact.x).max() < 0.01 * np.abs(exact.x).max()


@pytest.mark.parametrize("kind", ["A", "term"])
@pytest.mark.parametrize(
    ("across", "down", "centre", "duration"),
    [
        (3, 0, 1, 3.0), (3, 0, 1.5, 3.0), (2, -2, 1, 3.0), (1, 0, 1, 30.0), (0.3, 0, 1, 30.0), (12, 0, 1, 2.0),
        (2, 0, 0, 2.0), (2, 0, 0, 1.0), (1, 0, 0, 3.0), (3, 0, 0.9, 3.0),
        (1, 0, 2, 1.0), (1, 0, 2, 3.0), (1, 0, 2, 30.0), (0.5, 0, 2, 30.0), (1, 0, 3, 30.0), (2, 0, 3, 30.0),
    ],
)  # fmt: skip
def test_what_turns_is_followed_wherever_it_decays_stands_or_grows(
    across: float, down: float, centre: float, duration: float, kind: str
) -> None:
    """The plan's own choice against scipy's DOP853, with eigenvalues on both sides of the imaginary axis.

    Its steps follow a turn to three digits; what grows while it turns ten times may lose one of them.
    """
    A = [[0, -down, 0], [-across, centre, across], [0, down, 0]]
    template = Template(A) if kind == "A" else Template([[0.0]], terms=[Term(A)])
    x = np.random.default_rng(0).uniform(-0.3, 0.3, (6, 16))  # it turns along the rows
    ours = run_transient(template, state=x, boundary=fixed(0), duration=duration)
    end = exact(A, x, duration)
    assert np.abs(ours.x - end).max() < 0.02 * np.abs(end).max()


def test_layers_that_turn_without_end_are_followed() -> None:
    """x' = -6 v, v' = 6 x while |x|, |v| < 1: rotation, by 18 in 3 time constants."""
    network = LayeredTemplate([Template([[1.0]], terms=[Term([[w]], layer=n)]) for w, n in ((-6.0, 1), (6.0, 0))])
    x = np.random.default_rng(1).uniform(-0.3, 0.3, (2, 6, 7))
    end = run_transient(network, state=x, boundary=fixed(0), duration=3.0).x
    turned = x[0] * np.cos(18) - x[1] * np.sin(18), x[0] * np.sin(18) + x[1] * np.cos(18)
    np.testing.assert_allclose(end, turned, atol=0.02)


@pytest.mark.parametrize("name", ["connected-components-horizontal", "masked-connected-components-left", "shadow-up"])
def test_waves_that_saturate_before_they_turn_keep_the_quicker_scheme(name: str) -> None:
    entry = library.load(name)
    for duration in ("settled", 3.0, 30.0):
        plan = make_plan(entry.template, (16, 16), entry.boundary, duration=duration)
        assert plan.scheme is EULER


@pytest.mark.parametrize("kind", ["A", "term"])
def test_what_grows_fast_is_followed_from_grey_alone(kind: str) -> None:
    """A of connected components: waves between saturated cells end as they should, a grey start may end otherwise."""
    A = [[0, 0, 0], [1, 2, -1], [0, 0, 0]]
    template = Template(A) if kind == "A" else Template([[0.0]], terms=[Term(A)])
    black = np.random.default_rng(3).random((12, 12)) > 0.5
    chosen = {}
    for name, x in (("black and white", np.where(black, 1.0, -1.0)), ("grey", np.where(black, 0.2, -0.2))):
        ours = run_transient(template, state=x, boundary=fixed(0), duration=30.0)
        end = exact(A, x, 30.0)
        assert np.array_equal(np.sign(ours.x), np.sign(end))
        assert ours.plan.scheme is not None
        chosen[name] = ours.plan.scheme.name
    assert chosen == {"black and white": "euler", "grey": "rk4"}
    euler = run_transient(template, state=x, boundary=fixed(0), duration=30.0, scheme="euler", step=0.1)
    assert not np.array_equal(np.sign(euler.x), np.sign(end))


@pytest.mark.parametrize("kind", ["A", "term"])
def test_a_short_step_that_is_asked_for_lets_the_cheaper_scheme_stand(kind: str) -> None:
    """It turns at 6: by h omega^2 / 2 a time constant Euler's steps of 0.002 make it 7 % too large in two of them."""
    template = Template(TURNING) if kind == "A" else Template([[0.0]], terms=[Term(TURNING)])
    x = np.random.default_rng(0).uniform(-0.3, 0.3, (16, 16))
    end = exact(TURNING, x, 2.0)
    for step, name in ((0.05, "rk4"), (0.01, "rk4"), (0.002, "euler"), (0.0005, "euler")):
        ours = run_transient(template, state=x, boundary=fixed(0), duration=2.0, step=step)
        assert ours.plan.scheme is not None
        assert ours.plan.scheme.name == name
        assert np.abs(ours.x - end).max() < 0.07 * np.abs(end).max()


def flow(A: Sequence[Sequence[float]], x: Floats, boundary: Boundary, duration: float) -> Floats:
    """The classical Runge-Kutta scheme by steps of 1/50, with nothing of the emulator's."""
    ways: dict[str, Any] = {"fixed": {"constant_values": boundary.y}, "zero-flux": {"mode": "edge"}}
    (rows, cols), h = x.shape, 0.02

    def rate(x: Floats) -> Floats:
        y = np.pad(x.clip(-1, 1), 1, **ways.get(boundary.kind, {"mode": "wrap"}))
        taps = [(weight, y[k : k + rows, l : l + cols]) for k, row in enumerate(A) for l, weight in enumerate(row)]
        return sum((weight * part for weight, part in taps if weight), -x)

    for _ in range(round(duration / h)):
        k1 = rate(x)
        k2 = rate(x + h / 2 * k1)
        k3 = rate(x + h / 2 * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3))
    return x


@pytest.mark.parametrize("boundary", [fixed(0), fixed(0.5), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("across", [(1, 2, 2), (1, -1, 2)])
def test_waves_that_grow_as_they_travel_are_followed_from_grey(across: tuple[float, ...], boundary: Boundary) -> None:
    """On a grid with edges they are no modes, but are there until they come to an edge."""
    A = [[0, 0, 0], across, [0, 0, 0]]
    x = np.random.default_rng(0).uniform(-1, 1, (16, 16))
    exact = flow(A, x, boundary, 12.0)
    found = run_transient(Template(A), state=x, boundary=boundary, duration=12.0, dtype="float64")
    assert np.array_equal(found.x > 0, exact > 0), found.plan.explain()
    assert np.abs(found.y - exact.clip(-1, 1)).max() < 0.005
