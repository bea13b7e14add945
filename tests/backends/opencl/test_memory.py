"""What stays on the device during a program, and how much memory a transient takes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import Template, Term
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.planning.scheme import SCHEMES
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.task import make_task
from tests.backends.conformance.test_schemes import THREE_EIGHTHS
from tests.kits.opencl import OpenCLBackend, cl

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])


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


TERM = Template(NINE, NINE, terms=[Term(NINE, "y_kl - u_ij", times="x_kl")])
CASES: dict[str, tuple[Template, dict[str, Any], int]] = {
    "euler": (Template(NINE, NINE), {}, 5),
    "heun": (Template(NINE, NINE), {"scheme": "heun"}, 10),
    "rk4": (Template(NINE, NINE), {"scheme": "rk4"}, 12),
    "full range": (Template(NINE, NINE), {"scheme": "rk4", "cell": "full-range"}, 12),
    "keeps rates": (Template(NINE, NINE), {"scheme": "3/8"}, 16),
    "closed form": (Template(2.0, NINE), {}, 3),
    "terms by euler": (TERM, {"scheme": "euler"}, 9),
    "terms by rk4": (TERM, {"scheme": "rk4"}, 12),
    "discrete time": (Template(0.5, NINE), {"cell": "discrete-time"}, 7),
    "delay": (Template(NINE, NINE, terms=[Term(0.1, "x_kl", delay=0.2)]), {}, 13),
}


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("case", CASES)
def test_a_transient_takes_the_planes_that_the_check_before_it_counts(
    case: str, dtype: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In planes of the dtype: state, input, what the steps work in, and the result."""
    monkeypatch.setitem(SCHEMES, "3/8", THREE_EIGHTHS)
    template, choices, wanted = CASES[case]
    backend = OpenCLBackend(dtype)
    x, u = np.zeros((2, 1097, 1030), dtype)
    choices = {"step": None if case in ("closed form", "discrete time") else 0.1, "duration": 3.0, **choices}
    task = make_task(template, state=x, input=u, **choices)
    planes, real = 2.0, DeviceContext.buffer

    def counted(self: Any, size: int) -> Any:
        nonlocal planes
        planes += round(size / x.nbytes)
        return real(self, size)

    monkeypatch.setattr(DeviceContext, "buffer", counted)
    task.start(backend)
    assert planes == wanted
    assert task.cell_bytes(x.itemsize, "opencl") == wanted * x.itemsize


def test_large_planes_are_not_copied_where_the_device_is_the_processor() -> None:
    backend = OpenCLBackend()
    if not backend._context.works_in_place(1 << 30):
        pytest.skip("the device has memory of its own")
    x = np.random.default_rng(4).uniform(-1, 1, (1030, 1031)).astype(np.float32)
    kept = x.copy()
    task = make_task(Template(2.0, z=0.5), state=x, duration=1.0)
    given, end = backend.load(x, "lam", copy=False), task.start(backend).x
    assert cl.enqueue_map_buffer(
        backend._context.queue, given.buffer, cl.map_flags.READ, 0, x.shape, x.dtype
    )[0].ctypes.data == x.ctypes.data  # fmt: skip
    copied, out = backend.read(end), backend.read(end, copy=False)
    again = backend.read(end, copy=False)
    assert np.shares_memory(out, again)
    assert not np.shares_memory(out, copied)
    del end
    other = [task.start(backend) for _ in range(4)]  # none of them lies in what was handed out
    np.testing.assert_array_equal(out, copied)
    out[:] = 7
    np.testing.assert_array_equal(backend.read(other[0].x), copied)
    np.testing.assert_array_equal(x, kept)
    stays = make_task(Template(NINE), state=x, duration=0.0).start(backend).x
    assert not np.shares_memory(backend.read(stays, copy=False), x)
