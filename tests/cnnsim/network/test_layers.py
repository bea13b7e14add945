"""Networks of layers: time constants, coupling, batches, waves, patterns, life, path tracing."""

from typing import Any

import numpy as np
import pytest
from scipy import linalg, ndimage

from cnnsim import PERIODIC, InputError, Template, fixed, library, run, run_transient
from cnnsim.network import LayeredTemplate, Term
from tests.oracles import kinds
from tests.oracles.pictures import black, plane

both = pytest.mark.parametrize("backend", ["reference", "cpu"])


@both
def test_two_layers_in_the_linear_region_are_a_matrix_exponential(backend: str) -> None:
    """T x' = (A - 1) x between the layers of one cell, with time constants of their own."""
    coupling, times = np.array([[0.3, -0.6], [0.8, 0.1]]), np.array([1.0, 2.5])
    layers = [Template(coupling[l, l], terms=[Term(coupling[l, 1 - l], "y_kl", layer=1 - l)]) for l in range(2)]
    start = np.array([0.4, -0.3])
    network = LayeredTemplate(layers, times.tolist())
    end = run_transient(network, state=start.reshape(2, 1, 1), duration=3.0, scheme="rk4",
                        step=0.01, backend=backend, dtype="float64").x.ravel()  # fmt: skip
    assert np.abs(end - linalg.expm((coupling - np.eye(2)) / times[:, None] * 3.0) @ start).max() < 1e-9


@both
def test_layers_without_coupling_are_two_networks(backend: str) -> None:
    rng = np.random.default_rng(1)
    parts = [Template(rng.normal(size=(3, 3)) * 0.3, rng.normal(size=(3, 3)), rng.normal()) for _ in range(2)]
    x, u = rng.uniform(-1, 1, (2, 2, 5, 6))
    task: dict[str, Any] = {"duration": 2.0, "scheme": "heun", "step": 0.1, "backend": backend, "dtype": "float64"}
    together = run_transient(LayeredTemplate(parts), state=x, input=u, boundary=fixed(0.3), **task).x
    for part, x0, u0, end in zip(parts, x, u, together, strict=True):
        alone = run_transient(part, state=x0, input=u0, boundary=fixed(0.3), **task).x
        assert np.abs(end - alone).max() < 1e-13


@both
def test_a_batch_of_layered_grids(backend: str) -> None:
    rng = np.random.default_rng(2)
    entry = library.load("autowave")
    x, mask = rng.uniform(-1, 1, (3, 2, 6, 7)), rng.uniform(-1, 1, (3, 2, 6, 7))
    task: dict[str, Any] = {"duration": 2.0, "backend": backend, "dtype": "float64"}
    ends = run_transient(entry.network, state=x, mask=mask, **task).x
    for k in range(3):
        assert np.array_equal(run_transient(entry.network, state=x[k], mask=mask[k], **task).x, ends[k])
    assert np.array_equal(ends[mask > 0], x[mask > 0])


def test_layers_are_checked() -> None:
    two = LayeredTemplate([Template(0), Template(0, 1.0)])
    with pytest.raises(InputError, match="needs an input"):
        run_transient(two, state=np.zeros((2, 3, 3)))
    with pytest.raises(InputError, match=r"\(2, rows, cols\)"):
        run_transient(two, state=np.zeros((3, 3)), input=np.zeros((3, 3)))
    with pytest.raises(InputError, match="reads layer 2; 0 to 1"):
        LayeredTemplate([Template(0, terms=[Term([[1.0]], layer=2)]), Template(0)])
    with pytest.raises(InputError, match="time constants"):
        LayeredTemplate([Template(0)], [0.0])
    with pytest.raises(InputError, match="has 2 layers"):
        _ = library.load("autowave").template


@both
def test_a_ring_runs_outwards_and_the_middle_recovers(backend: str) -> None:
    start = -np.ones((2, 31, 31))
    start[0, 13:18, 13:18] = 1
    radius = []
    for t in (4.0, 8.0, 12.0):
        y = run("autowave", start, duration=t, backend=backend).y[0]
        row = np.flatnonzero(y[15] > 0)
        assert row.min() + row.max() == 30
        assert y[15, 15] < 0
        assert np.allclose(y, y.T, atol=1e-4)
        radius.append(int(row.max()) - 15)
    assert np.all(np.diff(radius) > 0)
    assert np.ptp(np.diff(radius)) <= 1, "steady speed"


@both
@pytest.mark.parametrize("mode", [0, 1, 2, 4])
def test_turing_modes_grow_as_the_dispersion_says(mode: int, backend: str) -> None:
    """Activator and inhibitor: at rest alone, unstable where the inhibitor spreads; the rate is an eigenvalue."""
    cells, d1, d2 = 8, 0.05, 1.0
    self_1, self_2, cross_1, cross_2 = 1.5, 0.2, -0.9, 0.9
    layers = [
        Template([[0, d, 0], [d, own - 4 * d, d], [0, d, 0]], terms=[Term([[cross]], "y_kl", layer=1 - l)])
        for l, (own, d, cross) in enumerate([(self_1, d1, cross_1), (self_2, d2, cross_2)])
    ]
    laplacian = 2 * np.cos(2 * np.pi * mode / cells) - 2
    jacobian = np.array([[self_1 - 1 + d1 * laplacian, cross_1], [cross_2, self_2 - 1 + d2 * laplacian]])
    rates = np.linalg.eigvals(jacobian).real.max()
    assert (rates > 0) == (mode in (2, 4))
    wave = np.cos(2 * np.pi * mode * np.arange(cells) / cells) * np.ones((3, 1))
    start = 1e-3 * np.array([wave, 0.2 * wave])
    end = run_transient(LayeredTemplate(layers), state=start, boundary=PERIODIC, duration=4.0, scheme="rk4", step=0.02,
                        backend=backend, dtype="float64").x  # fmt: skip
    wanted = linalg.expm(4.0 * jacobian) @ np.array([1e-3, 0.2e-3])
    assert np.abs(end - wanted[:, None, None] * wave).max() < 1e-9


@both
@pytest.mark.parametrize("name", ["life-discrete", "life-discrete-1-layer"])
def test_ten_generations_of_life(name: str, backend: str) -> None:
    alive = np.random.default_rng(3).random((12, 13)) < 0.4
    for _ in range(10):
        y = run(name, plane(alive), backend=backend).y
        alive = kinds.life(alive)
        assert np.array_equal(black(y if y.ndim == 2 else y[2]), alive)


@both
def test_only_the_marked_object_is_traced(backend: str) -> None:
    film, mark = -np.ones((5, 9, 12)), -np.ones((9, 12))
    for k in range(5):
        film[k, 1:3, 1 + k : 3 + k] = 1
        film[k, 6:8, 8 - k : 10 - k] = 1
    mark[1:3, 1:3] = 1
    y = run("path-tracing", film, state=mark, backend=backend).y
    object_now, path = black(y[0]), black(y[1])
    assert np.array_equal(
        object_now, ndimage.binary_propagation(mark > 0, mask=(film[-1] > 0) | (mark > 0)) & (film[-1] > 0)
    ) or (object_now[:5].any() and not object_now[5:].any())
    assert np.array_equal(path[:5], (film.max(axis=0) > 0)[:5])
    assert not path[5:].any()
    nothing = run("path-tracing", film, state=-np.ones_like(mark), backend=backend).y
    assert not (nothing > 0).any()
