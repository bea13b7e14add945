"""Every backend against the reference on random networks of all kinds: terms, delays, layers, sequences, cells."""

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, backends, fixed, library, run, run_transient
from cnnsim.backends.base import Backend
from cnnsim.library.catalogue import run_example
from cnnsim.network.characteristic import Cell, Characteristic
from cnnsim.network.frames import Frames
from cnnsim.network.layers import LayeredTemplate
from cnnsim.network.table import Table, lines
from cnnsim.network.term import Term

BACKENDS = ["cpu", "opencl cpu", "opencl gpu"]
ARGUMENTS = ["y_kl", "u_kl", "x_kl", "u_kl - u_ij", "y_kl - y_ij", "x_kl - x_ij", "u_kl - x_ij", "y_kl - u_ij"]


def backend_of(name: str, dtype: Any) -> Backend:
    """A backend, of OpenCL with one of its two families of kernels; skipped where there is no OpenCL."""
    if not name.startswith("opencl"):
        return backends.get(name, dtype)
    pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")
    from cnnsim.backends.opencl import device as opencl_device
    from cnnsim.backends.opencl.backend import OpenCLBackend

    if not opencl_device.devices():
        pytest.skip("there is no OpenCL device")
    return OpenCLBackend(dtype, family=cast(Any, name.split()[1]))


def random_table(rng: np.random.Generator) -> Table:
    """Linear: a step would turn rounding errors into jumps; the tests of terms have those."""
    at = np.sort(rng.uniform(-2, 2, 4)) + np.arange(4) * 0.5
    return lines(*zip(at.tolist(), rng.uniform(-0.5, 0.5, 4).tolist(), strict=True))


def random_term(rng: np.random.Generator, shape: tuple[int, int], layers: int, delays: bool) -> Term:
    side = int(rng.choice([1, 3, 5]))
    weights = rng.normal(size=(side, side)) * 0.3 / side**2
    varying = rng.random() < 0.3
    return Term(
        weights[..., None, None] * rng.uniform(0.5, 1, shape) if varying else weights,
        str(rng.choice(ARGUMENTS)),
        random_table(rng) if rng.random() < 0.7 else None,
        str(rng.choice(ARGUMENTS)) if rng.random() < 0.3 else None,
        float(rng.choice([0.1, 0.3, 1.0])) if delays and rng.random() < 0.6 else 0.0,
        int(rng.integers(layers)) if rng.random() < 0.4 else None,
    )


CELLS = [
    Cell(), Cell("full-range"), Cell("chua-yang", Characteristic("tanh", 2.0)),
    Cell("chua-yang", Characteristic(slope=3)),
    Cell("chua-yang", Characteristic("table", table=lines((-1.5, -1), (0, 0.2), (1, 1)))),
    Cell("discrete-time", Characteristic()),
]  # fmt: skip


def task_of(seed: int, planes: int) -> dict[str, Any]:
    """A random network, cell, boundary and scheme by the seed; its planes by both numbers."""
    rng = np.random.default_rng(seed)

    def coin() -> bool:
        return bool(rng.random() < 0.5)

    layers, grid = int(rng.integers(1, 4)), (int(rng.integers(1, 10)), int(rng.integers(1, 10)))
    cell, delays = CELLS[rng.integers(len(CELLS))], coin()
    if cell.model == "discrete-time":
        delays = False
    parts = [
        Template(rng.normal(size=(3, 3)) * 0.3, rng.normal(size=(3, 3)) * 0.3, rng.normal(),
                 terms=[random_term(rng, grid, layers, delays) for _ in range(rng.integers(1, 4))])
        for _ in range(layers)
    ]  # fmt: skip
    constants = None if cell.model == "discrete-time" else rng.uniform(0.5, 3, layers).tolist()
    boundary = [ZERO_FLUX, PERIODIC, fixed(-1.0), fixed(0.3, -0.7)][rng.integers(4)]
    scheme = None if cell.model == "discrete-time" else str(rng.choice(["euler", "heun", "exponential-euler"]))
    shape: tuple[int, ...] = (layers, *grid) if layers > 1 else grid
    rng = np.random.default_rng([seed, planes])
    if coin():
        shape = (int(rng.integers(1, 4)), *shape)
    frames = coin()
    u = rng.uniform(-1, 1, (3, *shape))
    every = 1.0 if cell.model == "discrete-time" else 0.4
    return {
        "template": LayeredTemplate(parts, constants) if layers > 1 else parts[0],
        "state": rng.uniform(-1, 1, shape),
        "input": Frames(list(u), every) if frames else u[0],
        "bias": Frames(list(rng.normal(size=(2, *shape))), every) if coin() else rng.normal(size=shape),
        "mask": rng.uniform(-1, 1, shape) if coin() else None,
        "boundary": boundary,
        "scheme": scheme,
        "cell": cell,
        "duration": 3.0 if cell.model == "discrete-time" else 1.2,
    }


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-12), ("float32", 1e-5)])
@settings(max_examples=20)
@given(seed=st.integers(0, 2**32))
def test_agrees_with_the_reference(backend: str, dtype: Any, tolerance: float, seed: int) -> None:
    for planes in range(2):  # an OpenCL device compiles each network
        task = task_of(seed, planes)
        law = run_transient(**task, backend="reference")
        ours = run_transient(**task, backend=backend_of(backend, dtype))
        assert np.abs(ours.x - law.x).max() <= tolerance * (1 + task["template"].state_bound(1.0))
        assert ours.t == law.t


ENTRIES = [library.load(name) for name in library.names()]
KINDS = [e.name for e in ENTRIES if not (isinstance(e.network, Template) and e.template.linear) or e.cell != Cell()]


@pytest.mark.parametrize("backend", ["opencl cpu", "opencl gpu"])
@pytest.mark.parametrize("name", KINDS)
def test_the_library_on_opencl(name: str, backend: str) -> None:
    """The other backends run all examples in the tests of the library."""
    entry, where = library.load(name), backend_of(backend, "float32")
    for example in entry.examples:
        assert example.holds(run_example(entry, example, backend=where).y)


@pytest.mark.parametrize("backend", BACKENDS)
def test_discrete_time_on_every_backend(backend: str) -> None:
    rng = np.random.default_rng(5)
    picture, where = np.where(rng.random((2, 9, 11)) < 0.6, 1.0, -1.0), backend_of(backend, "float32")
    law = [run("discrete-hole-filler", grid, backend="reference") for grid in picture]
    ours = run("discrete-hole-filler", picture, backend=where)
    assert np.array_equal(ours.y, np.stack([result.y for result in law]))
    assert ours.t == max(result.t for result in law)
    with pytest.raises(InputError, match="has not settled"):
        run_transient(Template([[-1.0]]), state=picture, cell="discrete-time", backend=where)


@pytest.mark.parametrize("backend", ["reference", *BACKENDS])
def test_a_state_that_overflows_is_found(backend: str) -> None:
    growing = Template(0, terms=[Term([[3.0]], "x_kl")])
    with pytest.raises(InputError, match=r"the state is (inf|nan) in cell"):
        run_transient(growing, state=[[1e300]], duration=60.0, backend=backend_of(backend, "float64"))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("kind", ["right", "left", "linear"])
@pytest.mark.parametrize("places", [0, 1, 2, 3, 4, 5, 6, 9])
def test_tables_at_and_beside_their_places(backend: str, dtype: Any, kind: Any, places: int) -> None:
    """Numbers are eighths at distances of a quarter, so that slopes, values and differences are exact everywhere."""
    rng = np.random.default_rng(places)
    at = (np.cumsum(rng.choice([0.25, 0.5], places)) - places / 4).tolist()
    values = (rng.integers(-8, 9, places + 1) / 8).tolist()
    if kind == "linear":
        at = [*at, at[-1] + 0.5 if at else 0.0]
    table = Table("linear", at, values) if kind == "linear" else Table("step", at, values, kind)
    near = np.array([*at, -8.0, 0.0, 8.0], dtype)
    v = np.concatenate([near, np.nextafter(near, -np.inf, dtype=dtype), np.nextafter(near, np.inf, dtype=dtype)])
    u = np.array([v, v[::-1]], np.float64)
    template = Template(0, terms=[Term([[0.5]], "u_kl", table)])
    found = run_transient(template, state=np.zeros(u.shape), input=u, backend=backend_of(backend, dtype)).x
    assert np.abs(found - 0.5 * table(u)).max() <= (0 if kind != "linear" else 4 * np.finfo(dtype).eps)
    # The same in the time loop: from x = 0 a step of Euler goes an eighth of the way to the drive.
    moving = Template(0, terms=[Term([[0.5]], "u_kl - x_ij", table)])
    end = run_transient(
        moving, state=np.zeros(u.shape), input=u, duration=0.125, step=0.125, backend=backend_of(backend, dtype)
    )
    assert np.array_equal(end.x, found / 8)


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_sigmoid_of_single_precision(backend: str) -> None:
    u = np.linspace(-1, 1, 4001).reshape(1, -1)
    found = run_transient(
        Template(0, [[16.0]]), state=np.zeros(u.shape), input=u, duration=1.0,
        cell=Cell("discrete-time", Characteristic("tanh")), backend=backend_of(backend, "float32"),
    ).y  # fmt: skip
    exact = np.tanh((16 * u.astype(np.float32)).astype(np.float64))
    assert np.abs(found - exact).max() <= 2e-7
    assert np.abs(found).max() <= 1
