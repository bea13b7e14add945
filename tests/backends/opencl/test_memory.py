"""What stays on the device during a program, and how much memory a transient takes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import Template, Term
from cnnsim.backends.opencl.device.pages import works_in_memory
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
    "heun": (Template(NINE, NINE), {"scheme": "heun"}, 5),
    "rk4": (Template(NINE, NINE), {"scheme": "rk4"}, 5),
    "full range": (Template(NINE, NINE), {"scheme": "rk4", "cell": "full-range"}, 5),
    "keeps rates": (Template(NINE, NINE), {"scheme": "3/8"}, 5),
    "closed form": (Template(2.0, NINE), {}, 3),
    "terms by euler": (TERM, {"scheme": "euler"}, 5),
    "terms by rk4": (TERM, {"scheme": "rk4"}, 5),
    "discrete time": (Template(0.5, NINE), {"cell": "discrete-time"}, 5),
    "delay": (Template(NINE, NINE, terms=[Term(0.1, "x_kl", delay=0.2)]), {}, 7),
}


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("case", CASES)
def test_a_transient_takes_what_the_check_before_it_counts(
    case: str, dtype: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five planes at most of the dtype computed in: state, input, w, and two between which the steps go by turns.

    They are counted on the device, to which small ones are brought; what tiles work in is as large on any grid.
    """
    monkeypatch.setitem(SCHEMES, "3/8", THREE_EIGHTHS)
    template, choices, wanted = CASES[case]
    backend = OpenCLBackend(dtype)
    rows = 1097 + list(CASES).index(case)  # a size that no other test leaves planes of in the pool
    x, u = np.zeros((2, rows, 514), dtype)
    choices = {"step": None if case in ("closed form", "discrete time") else 0.1, "duration": 3.0, **choices}
    task = make_task(template, state=x, input=u, **choices)
    planes = 0.0
    real = cl.Buffer

    def counted(*arguments: Any, **named: Any) -> Any:
        nonlocal planes
        buffer = real(*arguments, **named)
        planes += buffer.size / x.nbytes if 0.99 < buffer.size / x.nbytes < 1.01 else 0
        return buffer

    monkeypatch.setattr(cl, "Buffer", counted)
    task.start(backend)
    assert planes == pytest.approx(wanted, abs=0.01)
    assert task.cell_bytes(x.itemsize, "opencl") == wanted * x.itemsize


def test_large_planes_are_not_copied_where_the_device_is_the_processor() -> None:
    backend = OpenCLBackend()
    if not works_in_memory(backend.device):
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


def test_memory_of_a_plane_that_nobody_has_is_that_of_the_next() -> None:
    """A plane may be in use under two names, also as the end of a transient without a step."""
    backend, rng = OpenCLBackend(), np.random.default_rng(3)
    x = backend.load(rng.uniform(-1, 1, (1030, 1027)), "lam")
    plan = make_task(Template(2.0, z=0.5), state=np.zeros(x.shape, np.float32), duration="settled").plan
    first = backend.transient(plan, x, None).x
    ends, memory = backend.read(first), first.buffer.int_ptr
    again = backend.transient(plan, first, None).x  # first is in use, and its memory with it
    stays = backend.transient(make_task(Template(NINE), state=ends, duration=0.0).plan, first, None).x
    assert again.buffer.int_ptr != memory == stays.buffer.int_ptr
    del first
    assert backend.transient(plan, x, None).x.buffer.int_ptr != memory, "it has another name"
    np.testing.assert_array_equal(backend.read(stays), ends)
    del stays
    assert memory in [backend.transient(plan, x, None).x.buffer.int_ptr for _ in range(2)]
