"""Gradients: against forward sensitivities, finite differences and the states of the backends."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim import Boundary, Frames, InputError, LayeredTemplate, Template, Term, gradient, library, run_transient
from cnnsim.learning import adjoint
from cnnsim.learning.adjoint import AdjointTransient, weights_of, with_weights
from cnnsim.learning.gradient import Gradient
from cnnsim.network import AnyTemplate, layered
from cnnsim.task import make_task
from tests.kits.networks import BOUNDARIES, general_task, settling_task
from tests.oracles.sensitivities import Direction, end_and_tangent

MIRROR = Boundary("reflecting")
RNG = np.random.default_rng(0)
PICTURE, TARGET = RNG.uniform(-1, 1, (2, 2, 5, 6))
COUPLED = Template(RNG.normal(size=(3, 3)) / 3, RNG.normal(size=(3, 3)), 0.2)


def network(seed: int) -> dict[str, Any]:
    """Return a random linear network of any radius, scheme, cell, boundary, mask and batch, on a small grid."""
    task = settling_task(seed)
    rng = np.random.default_rng([seed, 1])
    cut = np.s_[..., : int(rng.integers(1, 7)), : int(rng.integers(1, 7))]
    planes: dict[str, Any] = {key: task[key][cut] for key in ("state", "input", "bias", "mask") if key in task}
    boundary = [*BOUNDARIES, MIRROR][rng.integers(1 + len(BOUNDARIES))]
    return {**task, **planes, "boundary": boundary, "duration": 1.27, "without": ["closed form"]}


def end_of(task: dict[str, Any], steps: int, **new: Any) -> Any:
    """Return the state after a number of steps."""
    run = AdjointTransient(make_task(**{**task, **new}), steps)
    return run.forward(weights_of(run.network), np.array([own.z for own in run.network.layers]), (steps,))[steps]


def differences(seed: int) -> tuple[float, float]:
    """Return the differences from sensitivities and from finite differences, relative to the gradient's size."""
    given = network(seed)
    task = make_task(**given)
    rng, template, steps, shape = np.random.default_rng([seed, 2]), given["template"], task.plan.steps, task.state.shape
    run = AdjointTransient(task, steps)
    x = run.forward(weights_of(layered(template)), np.array([template.z]), (steps,))[steps]
    bar = rng.normal(size=x.shape)
    pulled = run.backward({steps: bar})
    a, b = rng.normal(size=template.A.shape), rng.normal(size=template.B.shape)
    z, (bias, u, x0) = rng.normal(), rng.normal(size=(3, *shape))
    planes = zip((pulled.bias[0], pulled.input[0], pulled.state), (bias, u, x0), strict=True)
    parts = [pulled.weights * np.append(b, a), pulled.z * z, *(found.reshape(shape) * way for found, way in planes)]
    ours, size = (sum(float(f(part).sum()) for part in parts) for f in (np.positive, np.abs))
    end, tangent = end_and_tangent(task, steps, Direction(a, b, z, bias, u, x0))
    np.testing.assert_allclose(x.reshape(shape), end, atol=1e-12)
    fixed_step = {**given, "step": task.plan.step, "scheme": task.plan.scheme.name if task.plan.scheme else None}

    def loss(e: float) -> float:
        moved = Template(template.A + e * a, template.B + e * b, template.z + e * z)
        own = 0 if task.bias is None else task.bias
        new = {"state": task.state + e * x0, "input": task.input + e * u, "bias": own + e * bias}
        return float((end_of(fixed_step, steps, template=moved, **new) * bar).sum())

    finite = ours if task.plan.cell == "full-range" else (loss(1e-7) - loss(-1e-7)) / 2e-7  # there |x(0)| <= 1
    size = max(size, 1e-9)  # all cells may be stopped
    return abs(ours - float((tangent * bar.reshape(shape)).sum())) / size, abs(ours - finite) / size


@pytest.mark.parametrize("seeds", [range(20), pytest.param(range(200), marks=pytest.mark.slow)], ids=["few", "many"])
def test_gradients_are_those_of_sensitivities_and_of_finite_differences(seeds: range) -> None:
    found = np.array([differences(seed) for seed in seeds])
    assert found[:, 0].max() < 1e-12
    assert found[:, 1].max() < 1e-6


def single(found: Gradient) -> Template:
    """Return the derivatives by the weights of a single layer."""
    assert isinstance(found.template, Template)
    return found.template


def smooth(template: AnyTemplate) -> AnyTemplate:
    """Return a template with the parts that have a derivative: no delays, and one weight for all cells."""
    layers = [
        Template(own.A, own.B, own.z, terms=[
            replace(term, delay=0.0, weights=term.weights if term.weights.ndim == 2 else term.weights[..., 0, 0])
            for term in own.terms
        ])
        for own in layered(template).layers
    ]  # fmt: skip
    return LayeredTemplate(layers, template.time_constants) if isinstance(template, LayeredTemplate) else layers[0]


@pytest.mark.parametrize("seed", [4, 5, 6, 11, 15, 17, 18, 25, 31, 33])
def test_gradients_of_terms_layers_and_sequences_are_those_of_finite_differences(seed: int) -> None:
    given = general_task(seed, 0)
    given["template"] = smooth(given["template"])
    task = make_task(**given)
    assert task.plan.scheme is not None
    steps, rng, run = task.plan.steps, np.random.default_rng(seed), AdjointTransient(task, task.plan.steps)
    weights, z = weights_of(run.network), np.array([own.z for own in run.network.layers])
    x = run.forward(weights, z, (steps,))[steps]
    assert np.allclose(x.reshape(task.state.shape), run_transient(**given, backend="reference").x, atol=1e-12)
    bar = rng.normal(size=x.shape)
    pulled = run.backward({steps: bar})
    of_weights, of_z, of_state = rng.normal(size=weights.shape), rng.normal(size=z.shape), rng.normal(size=x.shape)
    ours = pulled.weights @ of_weights + pulled.z @ of_z + (pulled.state * of_state).sum()
    same = {**given, "step": task.plan.step, "scheme": task.plan.scheme.name}

    def loss(e: float) -> float:
        moved = with_weights(given["template"], weights + e * of_weights, z + e * of_z)
        state = task.state + e * of_state.reshape(task.state.shape)
        return float((end_of(same, steps, template=moved, state=state) * bar).sum())

    assert ours == pytest.approx((loss(1e-7) - loss(-1e-7)) / 2e-7, rel=1e-5, abs=1e-6)


def test_the_gradient_of_a_loss_is_that_of_finite_differences_at_times_and_at_rest() -> None:
    """The loss is that of the outputs of `run`, whose steady state is found in the same number of steps."""
    cases: list[dict[str, Any]] = [{"duration": 1.5}, {"times": [0.5, 0.0, 1.5]}, {"duration": "settled"}]
    for case in cases:
        target = np.stack([TARGET] * 3) if "times" in case else TARGET
        template = COUPLED if "settled" not in case.values() else Template(COUPLED.A / 3, COUPLED.B, 0.2)

        def loss(z: float, case: Any = case, target: Any = target, own: Any = template) -> Any:
            return gradient(Template(own.A, own.B, z), PICTURE, target, scheme="euler", step=0.05, **case)

        found = loss(0.2)
        assert single(found).z == pytest.approx((loss(0.2 + 1e-7).loss - loss(0.2 - 1e-7).loss) / 2e-7, rel=1e-6)
        assert found.bias.sum() == pytest.approx(single(found).z)
        assert found.y.shape == target.shape
    x = run_transient(template, state=PICTURE, input=PICTURE, scheme="euler", step=0.05, dtype="float64").y
    assert np.allclose(found.y, x, atol=1e-3)


def test_long_transients_keep_few_states_and_give_the_same_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = gradient(COUPLED, PICTURE, TARGET, duration=3.7)
    monkeypatch.setattr(adjoint, "KEPT_BYTES", 1000)
    task = make_task(COUPLED, state=PICTURE, input=PICTURE, duration=3.7)
    run = AdjointTransient(task, task.plan.steps)
    run.forward(weights_of(run.network), np.array([0.2]))
    assert len(run._kept) <= 2 * np.sqrt(task.plan.steps)
    again = gradient(COUPLED, PICTURE, TARGET, duration=3.7)
    assert np.array_equal(single(whole).A, single(again).A)
    assert np.array_equal(whole.state, again.state)


@pytest.mark.slow  # single precision and steady states compile further loops
def test_single_precision_two_threads_and_other_losses() -> None:
    exact = gradient("edge", PICTURE, TARGET, duration=2.0)
    rough = gradient("edge", PICTURE, TARGET, duration=2.0, dtype="float32")
    assert rough.state.dtype == np.float32
    np.testing.assert_allclose(single(rough).B, single(exact).B, rtol=1e-4, atol=1e-5)
    own = gradient(
        "edge", PICTURE, TARGET, lambda y, d: (float(((y - d) ** 2).mean()), 2 * (y - d) / y.size), duration=2.0
    )
    assert np.allclose(single(own).B, single(exact).B, rtol=1e-12)
    large = np.broadcast_to(np.tile(PICTURE[0], (8, 8)), (3, 40, 48))
    one, all_three = (
        gradient("edge", large[0], np.sign(large[0]), "hinge"),
        gradient("edge", large, np.sign(large), "hinge"),
    )
    assert np.allclose(single(one).B, single(all_three).B, rtol=1e-12)


def test_a_sequence_has_derivatives_by_each_plane() -> None:
    entry = library.load("motion-right")
    entry = replace(entry, network=smooth(entry.network))
    film = RNG.uniform(-1, 1, (3, 4, 5))
    found = gradient(entry, film, np.sign(film[0]), loss=lambda y, d: (float((y * d).sum()), d))
    assert isinstance(found.input, Frames)
    assert [plane.shape for plane in found.input.planes] == [(4, 5)] * 3


def test_bad_arguments_are_refused_in_one_line() -> None:
    cell = Template(2, 1)
    cases: list[tuple[str, dict[str, Any]]] = [
        ("target holds 2 in cell", {"targets": np.full((2, 5, 6), 2.0)}),
        ("target holds nan", {"targets": np.full((2, 5, 6), np.nan)}),
        (r"target has shape \(5, 6\), the outputs have \(2, 5, 6\)", {"targets": TARGET[0]}),
        ("with discrete time", {"cell": "discrete-time"}),
        ("with a delay", {"subject": Template(1, terms=[Term(1, delay=0.1)]), "duration": 1.0}),
        ("with an accuracy", {"accuracy": 0.1}),
        ("loss 'hing'; squares, hinge", {"loss": "hing"}),
        ("loss returned", {"loss": lambda y, _: (y, y)}),
        ("ends at 1", {"times": [2.0], "targets": TARGET[None], "duration": 1.0}),
        ("has not settled", {"subject": Template([[0, 0, 0], [-3, 2, 3], [0, 0, 0]], 1), "limit": 5.0}),
    ]  # fmt: skip
    for text, case in cases:
        with pytest.raises(InputError, match=text) as error:
            gradient(**{"subject": cell, "pictures": PICTURE, "targets": TARGET, **case})
        assert "\n" not in str(error.value)
