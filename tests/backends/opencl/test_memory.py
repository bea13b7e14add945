"""What stays on the device during a program, and how much memory a transient takes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim import Template
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.task import make_task
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


def test_memory_of_a_dense_transient(monkeypatch: pytest.MonkeyPatch) -> None:
    backend = OpenCLBackend()
    rows = 997  # a size that no other test leaves planes of in the pool
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
