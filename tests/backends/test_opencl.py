"""Transients and programs of the OpenCL backend, both families of kernels, against the reference."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed, library
from cnnsim.backends.base import NotFiniteError
from cnnsim.backends.reference.backend import ReferenceBackend
from cnnsim.planning.scheme import SCHEMES
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.transient import Task, make_task, run_transient

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl import device as opencl_device  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.backend import OpenCLBackend  # noqa: E402
from cnnsim.backends.opencl.tiles import cut  # noqa: E402

if not opencl_device.devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)

FAMILIES: Any = ["cpu", "gpu"]
NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
BOUNDARIES = [ZERO_FLUX, PERIODIC, fixed(0.5, -0.3), fixed(-1.0)]


def _random_task(seed: int, shape: tuple[int, ...] | None = None, **given: Any) -> Task:
    rng = np.random.default_rng(seed)
    r, s = (int(v) for v in rng.integers(1, 4, 2))
    a = rng.normal(size=(2 * r + 1, 2 * r + 1)) * (rng.random((2 * r + 1, 2 * r + 1)) < rng.choice([0.3, 1.0]))
    b = rng.normal(size=(2 * s + 1, 2 * s + 1))
    if shape is None:
        shape = tuple(int(v) for v in rng.integers(1, 24, 2))
        shape = (int(rng.integers(1, 4)), *shape) if rng.random() < 0.4 else shape
    maps: dict[str, Any] = {}
    if rng.random() < 0.5:
        maps["bias"] = rng.normal(size=shape)
    if rng.random() < 0.5:
        maps["mask"] = rng.uniform(-1, 1, shape)
    return make_task(
        Template(2 * a / max(np.abs(a).sum(), 1e-9), b / np.abs(b).sum(), rng.normal()),
        **{
            "state": rng.uniform(-1, 1, shape), "input": rng.uniform(-1, 1, shape), **maps,
            "boundary": BOUNDARIES[rng.integers(4)], "scheme": [None, *SCHEMES][rng.integers(1 + len(SCHEMES))],
            "cell": rng.choice(["chua-yang", "full-range"]), "duration": [1.27, "settled"][rng.integers(2)],
            "limit": 15.0, "without": ["blocking"] if rng.random() < 0.2 else [], **given,
        },
    )  # fmt: skip


def _assert_like_the_reference(task: Task, family: Any, dtypes: Any = ("float64", "float32")) -> None:
    law = task.start(ReferenceBackend())
    for dtype in dtypes:
        tolerance = {"float64": 1e-12, "float32": 1e-5}[dtype]
        backend = OpenCLBackend(dtype, family=family)
        ours = task.start(backend)
        x = backend.read(ours.x)
        assert x.dtype == dtype
        assert x.shape == task.state.shape
        bound = max(1.0, task.plan.template.state_bound(4.0))
        assert np.abs(x - law.x).max() <= tolerance * bound
        if dtype == "float64":
            assert ours[1:3] == law[1:3]
            assert ours.rate == pytest.approx(law.rate, rel=1e-9, abs=1e-11, nan_ok=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(6))
def test_random_transients(seed: int, family: Any) -> None:
    _assert_like_the_reference(_random_task(seed), family)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("shape", [(1, 1), (1, 5000), (5000, 3), (2, 3), (70, 1100)])
def test_hard_sizes(shape: tuple[int, int], boundary: Any, family: Any) -> None:
    template = Template(NINE, NINE.T, 0.1)
    if shape == (2, 3):  # smaller than the radius
        template = Template(np.random.default_rng(0).normal(size=(7, 7)) / 30, np.ones((11, 11)) / 121)
    rng = np.random.default_rng(1)
    task = make_task(
        template, state=rng.uniform(-2, 2, shape), input=rng.uniform(-1, 1, shape), boundary=boundary, duration=1.7
    )
    _assert_like_the_reference(task, family, ["float64"])


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", BOUNDARIES[:3], ids=str)
def test_many_steps_a_launch_give_the_same_bits(boundary: Any, family: Any) -> None:
    backend = OpenCLBackend("float64" if boundary is PERIODIC else "float32", family=family)
    rng = np.random.default_rng(2)
    for template, shape in ((Template(NINE), (70, 1100)), (Template(rng.normal(size=(5, 5)) / 5), (2, 40, 30))):
        x, mask = rng.uniform(-1, 1, shape), rng.uniform(-1, 0.3, shape)
        given: Any = {"state": x, "mask": mask, "boundary": boundary, "duration": 3.7, "scheme": "euler"}
        one, many = (make_task(template, **given, without=w).start(backend).x for w in (["blocking"], []))
        assert np.array_equal(backend.read(one), backend.read(many))


def test_shared_sums_stay_within_the_rounding_of_one_sum_a_step() -> None:
    task = [
        make_task(Template([[0.1, 0.2, 0.1], [0.2, 0.3, 0.2], [0.1, 0.2, 0.1]]), state=x, duration=5.0, without=w)
        for x in [np.random.default_rng(3).uniform(-1, 1, (40, 50))]
        for w in ([], ["shared sums"])
    ]
    backend = OpenCLBackend("float32", family="cpu")
    shared, plain = (backend.read(t.start(backend).x) for t in task)
    assert 0 < np.abs(shared - plain).max() < 50 * 1.5 * np.finfo(np.float32).eps


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", ["hole-filler", "connectivity", "shadow-left", "edge"])
def test_settled_pictures_and_their_step_counts(name: str, family: Any) -> None:
    entry = library.load(name)
    rng = np.random.default_rng(4)
    picture = np.where(rng.random((40, 70)) < 0.5, 1.0, -1.0)
    state = np.where(rng.random((40, 70)) < 0.1, picture, -1.0) if entry.initial_state == "given" else picture
    task = make_task(entry.template, state=state, input=picture, boundary=entry.boundary)
    law = task.start(ReferenceBackend())
    for dtype in ("float32", "float64"):
        ours = task.start(backend := OpenCLBackend(dtype, family=family))
        assert ours[1:3] == law[1:3]
        assert np.array_equal(backend.read(ours.x) > 0, law.x > 0)


@pytest.mark.parametrize("limit", [32 * 1024, 512 * 1024, 1024 * 1024])
def test_tiles_fit_into_the_local_memory_there_is(limit: int) -> None:
    """A device that is given more than it has writes over whatever lies behind."""
    shop: Any = SimpleNamespace(
        family="cpu", lanes=16, dtype=np.dtype("float64"), cores=2, device=SimpleNamespace(local_mem_size=limit)
    )
    for radius, shape in ((1, (1, 2048, 2048)), (1, (3, 40, 300)), (5, (1, 512, 512))):
        tiles = cut(shop, shape, radius, False, 1000, False)
        assert tiles.arguments[0].size <= limit
        assert 1 <= tiles.most_steps <= 24


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("name", ["hole-filler", "connected-components-horizontal"])
def test_sleeping_tiles_wake_up_where_a_wave_comes(name: str, boundary: Any, family: Any) -> None:
    """Two grids at once, three tiles beside each other, the last of them narrow; one grid settles much earlier."""
    picture = np.where(np.random.default_rng(8).random((2, 150, 265)) > 0.93, 1.0, -1.0)
    picture[0, 40:110, [60, 160]] = picture[0, [40, 110], 60:160] = 1
    picture[1, :, 20:] = -1
    entry, backend = library.load(name), OpenCLBackend("float32", family=family)
    planes: dict[str, Any] = {
        name: np.broadcast_to(plane, picture.shape) for name, plane in entry.planes(picture).items()
    }
    ends = []
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, boundary=boundary, limit=300.0, without=without).start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("scheme", [None, "euler", "rk4"])
@pytest.mark.parametrize("duration", [0.5, "settled"])
def test_a_state_that_is_no_number_is_named(duration: Any, scheme: Any, bad: float, family: Any) -> None:
    backend = OpenCLBackend("float32", family=family)
    template = Template(0.5 if scheme is None else NINE)
    x = np.zeros((9, 21))
    task = make_task(template, state=x, scheme=scheme, duration=duration, limit=2.0)
    x[4, 17] = bad
    with pytest.raises(NotFiniteError, match=r"the state is (nan|inf) in cell \("):
        task.start(backend, x)


def test_planes_stay_on_the_device_during_a_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (
        'name = "p"\nlam = ["a", "b"]\nllm = ["p", "q"]\nwire = ["n"]\ninputs = ["p"]\noutputs = ["q", "b", "n"]\n'
        '[[step]]\ntemplate = "edge"\ninput = "p"\nto = "a"\n[[step]]\ncellwise = "absolute"\nof = ["a"]\nto = ["b"]\n'
        '[[step]]\ncopy = "a"\nto = "q"\n[[step]]\nlogic = "xor"\nof = ["p", "q"]\nto = "q"\n'
        '[[step]]\nwire = "count"\nof = "q"\nto = "n"\n'
    )
    (tmp_path / "p.toml").write_text(text, encoding="utf-8")
    program = load_program(tmp_path / "p.toml")
    picture = np.random.default_rng(8).random((30, 41)) < 0.5
    backend = OpenCLBackend()
    traffic: list[str] = []
    for verb in ("load", "read"):
        real = getattr(backend, verb)

        def counted(*arguments: Any, real: Any = real, verb: str = verb) -> Any:
            traffic.append(verb)
            return real(*arguments)

        monkeypatch.setattr(backend, verb, counted)
    ours = UniversalMachine(backend).run(program, p=picture)
    law = UniversalMachine("reference").run(program, p=picture)
    assert traffic == ["load", "load", "read", "read"]  # the second is the constant plane that "edge" starts from
    assert ours["n"] == law["n"]
    assert np.array_equal(ours["q"], law["q"])
    assert np.allclose(ours["b"], law["b"])


def test_memory_of_a_dense_transient(monkeypatch: pytest.MonkeyPatch) -> None:
    backend = OpenCLBackend()
    rows = 997  # a size that no other test leaves spare planes of
    x = np.zeros((rows, 16), np.float32)
    task = make_task(Template(NINE, NINE), state=x, input=x, duration=10.0)
    planes = 0
    real = cl.Buffer

    def counted(*arguments: Any, **named: Any) -> Any:
        nonlocal planes
        buffer = real(*arguments, **named)
        planes += buffer.size == x.nbytes
        return buffer

    monkeypatch.setattr(cl, "Buffer", counted)
    task.start(backend)
    assert planes <= 5


def test_by_name_and_by_way_of_run_transient() -> None:
    x = np.random.default_rng(9).uniform(-1, 1, (20, 20))
    ours = run_transient(Template(NINE), state=x, duration=2.0, backend="opencl", dtype="float64")
    assert np.array_equal(ours.x, run_transient(Template(NINE), state=x, duration=2.0, backend="reference").x)
    with pytest.raises(InputError, match="the adaptive scheme runs on the reference backend"):
        run_transient(Template(NINE), state=x, duration=2.0, scheme="adaptive", backend="opencl")
