"""The verb for transients, one kind of network, cell or task after the other: each ends as on the reference."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Frames, LayeredTemplate, Template, Term, fixed
from cnnsim.backends.base import Backend
from cnnsim.network import Cell, Characteristic
from cnnsim.network.table import lines, steps
from cnnsim.task import make_task
from tests.kits.networks import assert_like_the_reference

RNG = np.random.default_rng(1)
X, U, BIAS, MASK = RNG.uniform(-1, 1, (4, 2, 7, 11))
FEEDBACK = np.array([[0.1, 0.3, 0.1], [0.2, 1.4, -0.1], [0, 0.3, 0.1]])
CONTROL = np.array([[0, 0.5, 0], [0.2, 1, -0.3], [0, 0, 0.4]])
COUPLED, UNCOUPLED = Template(FEEDBACK, CONTROL, 0.1), Template(1.5, CONTROL, 0.1)
WIDE = RNG.normal(size=(11, 11)) / 60
BELL = lines((-2, 0), (-0.5, 0), (0, 1), (0.5, 0), (2, 0))
PLAIN: dict[str, Any] = {"template": COUPLED, "state": X[0], "input": U[0], "duration": 1.3}
REST: dict[str, Any] = {**PLAIN, "duration": "settled"}


def terms(*given: Term, a: Any = 0.5, **more: Any) -> dict[str, Any]:
    return {**PLAIN, "template": Template(a, CONTROL, terms=given), "step": 0.1, **more}


TWO_LAYERS = LayeredTemplate(
    [Template(FEEDBACK, terms=[Term(-FEEDBACK, layer=1)]), Template(FEEDBACK.T, CONTROL, terms=[Term(0.3, layer=0)])],
    [1.0, 2.5],
)
CALM_LAYERS = LayeredTemplate([Template(0.3, CONTROL, terms=[Term(0.5, layer=1)]), Template(0.5)], [1.0, 2.5])
CASES: dict[str, dict[str, Any]] = {
    "closed form for a time": {**PLAIN, "template": UNCOUPLED},
    "closed form at rest": {**REST, "template": UNCOUPLED},
    "closed form, full range": {**PLAIN, "template": UNCOUPLED, "cell": "full-range"},
    "closed form with maps, a batch": {"template": UNCOUPLED, "state": X, "input": U, "bias": BIAS, "mask": MASK},
    "closed form of terms of the input": terms(Term(FEEDBACK, "u_kl - u_ij", BELL), step=None, duration="settled"),
    "steps for a time": PLAIN,
    "steps until settled": REST,
    "no time at all": {**PLAIN, "duration": 0.0},
    "a bias map": {**REST, "bias": BIAS[0]},
    "a mask": {**REST, "mask": MASK[0]},
    "all masked": {**REST, "mask": np.ones((7, 11))},
    "periodic": {**PLAIN, "boundary": PERIODIC},
    "fixed": {**PLAIN, "boundary": fixed(0.7, -0.4)},
    "one row": {**PLAIN, "state": X[0, :1], "input": U[0, :1], "boundary": PERIODIC},
    "one column": {**PLAIN, "state": X[0, :, :1], "input": U[0, :, :1], "boundary": ZERO_FLUX},
    "one cell": {**PLAIN, "state": X[0, :1, :1], "input": U[0, :1, :1], "boundary": fixed(0.5)},
    "a batch with maps": {**REST, "state": X, "input": U, "bias": BIAS, "mask": MASK},
    "radius 5 on 7 rows": {**PLAIN, "template": Template(WIDE, WIDE.T), "boundary": PERIODIC},
    "no feedback, stepped": {**PLAIN, "template": Template(0, CONTROL), "without": ["closed form"]},
    "full range": {**REST, "cell": "full-range"},
    "full range with stages": {**PLAIN, "cell": "full-range", "scheme": "heun"},
    "a term of outputs": terms(Term(FEEDBACK, "y_kl - y_ij", BELL)),
    "a term of states": terms(Term(FEEDBACK, "x_kl", BELL), duration="settled", limit=20.0),
    "a table of steps": terms(Term(FEEDBACK, "u_kl - u_ij", steps([-0.3, 0.4], [-1, 0.5, 1])), a=FEEDBACK),
    "a product": terms(Term(FEEDBACK, "y_kl", BELL, "u_kl - x_ij"), step=None),
    "weights by cell": terms(Term(RNG.normal(size=(3, 3, 7, 11)) * 0.2)),
    "a delay": terms(Term(FEEDBACK, "y_kl - u_ij", BELL, delay=0.4)),
    "terms with maps, a batch": terms(Term(FEEDBACK, "u_kl - x_ij"), state=X, input=U, bias=BIAS, mask=MASK),
    "layers": {**PLAIN, "template": TWO_LAYERS, "state": X, "input": U, "mask": MASK},
    "a batch of layers": {**PLAIN, "template": TWO_LAYERS, "state": np.stack([X, U, BIAS]), "boundary": fixed(0.2)},
    "layers until settled": {"template": CALM_LAYERS, "state": X, "input": U},
    "a sequence of inputs": {**PLAIN, "input": Frames(list(U), 0.5)},
    "sequences of inputs and biases": {**PLAIN, "input": Frames(list(U), 0.5), "bias": Frames(list(BIAS), 0.3)},
    "a sequence longer than the run": {**PLAIN, "input": Frames([U[0], U[1], X[1], BIAS[1]], 0.5), "scheme": "heun"},
    "discrete time": {**PLAIN, "state": np.sign(X[0]), "cell": "discrete-time", "duration": 4.0},
    "discrete time until settled": {**REST, "template": Template([[0, 0, 0], [1, 1, 0], [0, 0, 0]], 0, -0.5),
                                    "state": np.sign(X[0]), "cell": "discrete-time", "boundary": fixed(-1)},
    "discrete time with a sequence": {**PLAIN, "input": Frames(list(U), 2.0), "duration": 5.0,
                                      "cell": Cell("discrete-time", Characteristic())},
    "tanh": {**PLAIN, "cell": Cell("chua-yang", Characteristic("tanh", 2.0))},
    "a steep output": {**PLAIN, "cell": Cell("chua-yang", Characteristic(slope=4)), "duration": "settled"},
    "an output from a table": {**PLAIN, "cell": Cell("chua-yang", Characteristic("table", table=BELL))},
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_it_ends_as_on_the_reference(backend: Backend, case: str) -> None:
    task = make_task(**CASES[case])
    ours = assert_like_the_reference(backend, task, bound=5.0)
    assert ours.settled == (task.plan.duration == "settled")


def test_a_transient_that_does_not_settle_stops_at_its_limit(backend: Backend) -> None:
    """Two cells with opposite-sign coupling oscillate; so do discrete cells that turn their own sign."""
    across, self_feedback = np.array([[0, 0, 0], [-1.2, 0, 1.2], [0, 0, 0]]), np.diag([0.0, 2, 0])
    turning, term = Template(across + self_feedback), Template(2, terms=[Term(across)])
    for template in (turning, term):
        task = make_task(template, state=[[0.1, 0.0]], boundary=fixed(0), limit=12.0)
        ours = assert_like_the_reference(backend, task, bound=50.0)
        assert not ours.settled
        assert ours.t == pytest.approx(12)
        assert ours.rate > 0.1
    blinking = make_task(Template([[-1.0]]), state=[[1.0, -1.0]], cell="discrete-time", limit=7.0)
    assert not assert_like_the_reference(backend, blinking, bound=1.0).settled
