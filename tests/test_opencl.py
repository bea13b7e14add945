"""The OpenCL backend, both families of kernels, against the reference; and the choice of a device."""

from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, backends, cellwise, fixed, library
from cnnsim.backends.base import NotFiniteError
from cnnsim.backends.reference import ReferenceBackend
from cnnsim.cli_devices import devices
from cnnsim.logic import FUNCTIONS
from cnnsim.machine import UniversalMachine
from cnnsim.program_file import load_program
from cnnsim.scheme import SCHEMES
from cnnsim.transient import Task, make_task, run_transient
from tactile.inverse import STRAIN_INVERSE, STRESS_INVERSE

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends import opencl, opencl_device  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl import DevicePlane, OpenCLBackend  # noqa: E402
from cnnsim.backends.opencl_build import BuildError  # noqa: E402

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
            "boundary": BOUNDARIES[rng.integers(4)], "scheme": rng.choice([None, *SCHEMES]),
            "cell": rng.choice(["chua-yang", "full-range"]), "duration": [1.27, "settled"][rng.integers(2)],
            "limit": 15.0, "without": ["blocking"] if rng.random() < 0.2 else [], **given,
        },
    )  # fmt: skip


def _assert_like_the_reference(task: Task, family: Any) -> None:
    law = task.start(ReferenceBackend())
    for dtype, tolerance in (("float64", 1e-12), ("float32", 1e-5)):
        backend = OpenCLBackend(dtype, family=family)
        ours = task.start(backend)
        x = backend.read(ours.x)
        assert x.dtype == dtype
        assert x.shape == task.state.shape
        bound = max(1.0, task.plan.template.state_bound(0.0 if task.bias is None else np.abs(task.bias).max()))
        assert np.abs(x - law.x).max() <= tolerance * bound
        if dtype == "float64":
            assert ours[1:3] == law[1:3]
            assert ours.slope == pytest.approx(law.slope, rel=1e-9, abs=1e-11, nan_ok=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(10))
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
    _assert_like_the_reference(task, family)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", BOUNDARIES[:3], ids=str)
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_many_steps_a_launch_give_the_same_bits(dtype: Any, boundary: Any, family: Any) -> None:
    backend = OpenCLBackend(dtype, family=family)
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


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("shape", [(1, 1), (3, 63), (5, 64), (2, 3, 65), (300, 130)])
def test_logic_counting_and_conversion(shape: tuple[int, ...], family: Any) -> None:
    ours, law = OpenCLBackend(family=family), ReferenceBackend()
    p, q = np.random.default_rng(5).random((2, *shape)) < 0.5
    for function in range(len(FUNCTIONS)):
        plane = ours.logic(function, ours.load(p, "llm"), ours.load(q, "llm"))
        want = law.logic(function, p, q)
        assert np.array_equal(ours.read(plane), want)
        assert ours.count(plane) == want.sum()
    lam = ours.convert(ours.load(p, "llm"), "lam")
    assert np.array_equal(ours.read(lam), np.where(p, 1, -1))
    assert np.array_equal(ours.read(ours.convert(lam, "llm")), p)


@pytest.mark.parametrize("family", FAMILIES)
def test_output_keeps_nan(family: Any) -> None:
    backend = OpenCLBackend(family=family)
    y = backend.read(backend.output(backend.load(np.array([[-3, -0.5, 2, np.nan]]), "lam")))
    assert np.array_equal(y, np.array([[-1, -0.5, 1, np.nan]], np.float32), equal_nan=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", cellwise.BUILT_IN)
def test_cellwise(name: str, family: Any) -> None:
    operation = cellwise.BUILT_IN[name]
    backend = OpenCLBackend("float64", family=family)
    inputs = list(np.random.default_rng(6).normal(size=(len(operation.inputs), 7, 30)))
    inputs[0][3, 5] = np.nan
    parameters = (0.3, -2.0)[: len(operation.parameters)]
    got = backend.cellwise(operation, [backend.load(values, "lam") for values in inputs], parameters)
    for ours, law in zip(got, operation.array(*inputs, *parameters), strict=True):
        assert np.allclose(backend.read(ours), law, rtol=1e-15, atol=0, equal_nan=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-14), ("float32", 2e-6)])
@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_taxel_inverses(quantity: str, dtype: Any, tolerance: float, family: Any) -> None:
    rng = np.random.default_rng(7)
    signals = (rng.normal(size=(3, 40, 50)) * 10.0 ** rng.uniform(-7, -2, (40, 50))).astype(dtype)
    signals[:, 0, :5] = 0
    signals[0, 1, :3], signals[1, 2, :3], signals[:2, 3], signals[2, 4] = np.nan, np.inf, 0, 0
    operation = {"strain": STRAIN_INVERSE, "stress": STRESS_INVERSE}[quantity]
    operation = replace(operation, opencl=(files("tactile") / f"inverse_{quantity}.cl").read_text(encoding="utf-8"))
    backend = OpenCLBackend(dtype, family=family)
    for parameters in [(2e-3, 1e6, 1e-6, p) for p in (-1, 0, 1)] if quantity == "strain" else [(2e-3, 1e-6)]:
        got = backend.cellwise(operation, [backend.load(s, "lam") for s in signals], parameters)
        law = operation.array(*signals, *parameters)
        assert np.array_equal(backend.read(got[3]), law[3])
        for ours, want in zip(got[:3], law[:3], strict=True):
            assert np.allclose(backend.read(ours), want, rtol=tolerance, atol=0)


def test_an_operation_without_text_and_one_with_wrong_text() -> None:
    backend = OpenCLBackend()
    plane = backend.load(np.ones((2, 2)), "lam")
    add = cellwise.BUILT_IN["add"]
    with pytest.raises(InputError, match="'add' has no OpenCL text"):
        backend.cellwise(replace(add, opencl=""), [plane, plane], ())
    with pytest.raises(BuildError, match="undeclared identifier 'nothing'"):
        backend.cellwise(replace(add, opencl="sum = nothing;"), [plane, plane], ())


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
        monkeypatch.setattr(backend, verb, lambda *a, real=real, verb=verb: [traffic.append(verb), real(*a)][1])
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


def test_float64_needs_a_device_that_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opencl, "has_float64", lambda device: False)
    with pytest.raises(InputError, match="has no float64; use float32"):
        OpenCLBackend("float64")
    assert isinstance(OpenCLBackend("float32").load(np.zeros((1, 1)), "lam"), DevicePlane)
    with pytest.raises(InputError, match="float32 or float64, not in float16"):
        OpenCLBackend("float16")


def test_a_device_is_chosen_by_number_name_or_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(opencl_device.VARIABLE, raising=False)
    first = opencl_device.devices()[0]
    assert opencl_device.choose_device(0) == first
    assert opencl_device.choose_device(first.name[1:5].swapcase()) is not None
    with pytest.raises(InputError, match=r"no OpenCL device 99; there are 0: "):
        opencl_device.choose_device(99)
    with pytest.raises(InputError, match=r"no OpenCL device is called 'zx81'; there are 0: "):
        opencl_device.choose_device("zx81")
    monkeypatch.setenv(opencl_device.VARIABLE, "0")
    assert OpenCLBackend().device == first
    monkeypatch.setenv(opencl_device.VARIABLE, "zx81")
    with pytest.raises(InputError, match=r"'zx81' \(CNNSIM_DEVICE\)"):
        backends.get("opencl")


def test_without_a_platform_the_message_has_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cl, "get_platforms", list)
    with pytest.raises(InputError, match=r'no OpenCL device; pip install "pyopencl\[pocl\]"'):
        opencl_device.choose_device()


def test_without_pyopencl_the_message_has_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("opencl", "opencl_device", "opencl_build", "opencl_pocl", "opencl_tiles", "opencl_transient"):
        monkeypatch.delitem(__import__("sys").modules, f"cnnsim.backends.{module}", raising=False)
        monkeypatch.delattr(backends, module, raising=False)
    monkeypatch.setitem(__import__("sys").modules, "pyopencl", None)
    with pytest.raises(InputError, match=r'pip install "cellular-wave-touch\[opencl\]"'):
        backends.get("opencl")
    assert "cellular-wave-touch[opencl]" in str(CliRunner().invoke(devices).exception)


def test_devices_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(opencl_device.VARIABLE, raising=False)
    text, data = CliRunner().invoke(devices), CliRunner().invoke(devices, ["--json"])
    assert text.exit_code == data.exit_code == 0
    assert f"0  {opencl_device.devices()[0].name}" in text.output
    assert '"chosen": true' in data.output


def test_by_name_and_by_way_of_run_transient() -> None:
    x = np.random.default_rng(9).uniform(-1, 1, (20, 20))
    ours = run_transient(Template(NINE), state=x, duration=2.0, backend="opencl", dtype="float64")
    assert np.array_equal(ours.x, run_transient(Template(NINE), state=x, duration=2.0, backend="reference").x)
    with pytest.raises(InputError, match="the adaptive scheme runs on the reference backend"):
        run_transient(Template(NINE), state=x, duration=2.0, scheme="adaptive", backend="opencl")
