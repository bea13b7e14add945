"""What stays on the device during a program, and how much memory a transient takes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import Template, Term
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


CASES: dict[str, tuple[Template, dict[str, Any], int]] = {
    "euler": (Template(NINE, NINE), {}, 4),
    "heun": (Template(NINE, NINE), {"scheme": "heun"}, 5),
    "rk4": (Template(NINE, NINE), {"scheme": "rk4"}, 6),
    "full range": (Template(NINE, NINE), {"scheme": "rk4", "cell": "full-range"}, 6),
    "keeps rates": (Template(NINE, NINE), {"scheme": "3/8"}, 9),
    "closed form": (Template(2.0, NINE), {}, 2),
    "terms by euler": (Template(0.5, terms=[Term(NINE, "x_kl")]), {}, 8),
    "terms by rk4": (Template(0.5, terms=[Term(NINE, "x_kl")]), {"scheme": "rk4"}, 12),
    "discrete time": (Template(0.5, NINE), {"cell": "discrete-time"}, 8),
}


@pytest.mark.parametrize("case", CASES)
def test_a_transient_takes_what_the_check_before_it_counts(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The planes on the device, the state that is given included: x, w, and of four stages the sum, a stage, the next
    one and the step before; in the check the state and the result are counted outside of the device as well.
    """
    monkeypatch.setitem(SCHEMES, "3/8", THREE_EIGHTHS)
    template, choices, wanted = CASES[case]
    backend = OpenCLBackend()
    rows = 97 + list(CASES).index(case)  # a size that no other test leaves planes of in the pool
    x = np.zeros((rows, 514), np.float32)
    choices = {"step": 0.1 if "scheme" in choices else None, "duration": 10.0, **choices}
    task = make_task(template, state=x, input=x, **choices)
    planes = 0
    real = cl.Buffer

    def counted(*arguments: Any, **named: Any) -> Any:
        nonlocal planes
        buffer = real(*arguments, **named)
        planes += round(buffer.size / x.nbytes, 1) if buffer.size > 0.9 * x.nbytes else 0
        return buffer

    monkeypatch.setattr(cl, "Buffer", counted)
    task.start(backend)
    assert planes == pytest.approx(wanted, abs=0.4)  # channels have virtual cells
    assert task.cell_bytes(4, "opencl") / 4 - 2 == wanted


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
