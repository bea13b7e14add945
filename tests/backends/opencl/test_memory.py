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
