"""What a program takes on an engine is said before it runs: blocks, planes on the disk, and bytes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import cnnsim
from cnnsim.cli.group import main
from cnnsim.program.explain_large import explain_large
from cnnsim.program.last_use import used_last
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.shards import Shards
from tests.kits.program import load

pytest.importorskip("zarr")
CHAIN = """
name = "chain"
lam = ["a", "b"]
llm = ["p", "q", "r"]
inputs = ["p"]
outputs = ["r"]
[[step]]
logic = "not-p"
of = ["p"]
to = "q"
[[step]]
repeat = 2
[[step.do]]
logic = "or"
of = ["p", "q"]
to = "q"
[[step]]
copy = "q"
to = "a"
[[step]]
cellwise = "absolute"
of = ["a"]
to = ["b"]
[[step]]
copy = "b"
to = "r"
"""


def test_planes_are_let_go_after_the_last_step_that_needs_them(tmp_path: Path) -> None:
    program = load(tmp_path, CHAIN)
    last = used_last(program)
    assert [last[step] for step in program.steps] == [set(), {"p"}, {"q"}, {"a"}, {"b"}]


def test_the_planes_that_are_said_are_at_least_those_that_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, store, most = Shards.write, tmp_path / "store", [0]

    def measured(shards: Shards, *given: Any) -> None:
        write(shards, *given)
        files = [path for path in store.rglob("*") if path.is_file() and path.name != "zarr.json"]
        most[0] = max(most[0], sum(path.stat().st_size for path in files if "outputs" not in path.parts))

    monkeypatch.setattr(Shards, "write", measured)
    for name in ("gray-gradient", "texture-segmentation"):
        program = cnnsim.load_program(name)
        said = explain_large(program, (48, 64), Engine(side=16, workers=1))
        most[0] = 0
        planes: Any = {key: np.random.default_rng(1).random((48, 64)) - 0.5 for key in program.inputs}
        machine = cnnsim.UniversalMachine(engine=Engine(side=16, workers=1), store=store / name)
        machine.run(program, **planes)
        index = 20 * 12 * said.planes  # behind each shard
        assert 0.3 * said.disk_bytes < most[0] <= said.disk_bytes + index
        assert said.blocks == (3, 4)


def test_memory_of_a_worker_is_that_of_its_backend(tmp_path: Path) -> None:
    """What terms of the input add to the bias has a plane on OpenCL where there is no time loop, none on the CPU."""
    text = 'name = "p"\nlam = ["a", "b"]\ninputs = ["a"]\noutputs = ["b"]\n[[step]]\n'
    program = load(tmp_path, text + 'template = "average-gradient"\ninput = "a"\nto = "b"\n')
    cpu, opencl = (
        explain_large(program, (48, 64), Engine(side=16, workers=1), backend=name).worker_bytes
        for name in ("cpu", "opencl")
    )
    assert opencl - cpu == (16 + 2 * 1) ** 2 * 4
    call = ["explain", str(tmp_path / "p.toml"), "--size", "48x64", "--engine", "processes", "--workers", "1"]
    for name, needed in (("cpu", cpu), ("opencl", opencl)):
        told = CliRunner().invoke(main, [*call, "--block", "16", "--backend", name, "--json"])
        assert json.loads(told.output)["engine"]["worker_bytes"] == needed


def test_the_command_says_it() -> None:
    call = ["explain", "programs/skeleton", "--size", "32768x32768", "--engine", "processes", "--workers", "2"]
    told = CliRunner().invoke(main, call)
    assert told.exit_code == 0, told.output
    assert "blocks" in told.output
    assert "planes at a time" in told.output
    facts = json.loads(CliRunner().invoke(main, [*call, "--json"]).output)["engine"]
    assert facts["side"] * facts["blocks"][0] >= 32768 > facts["side"]
    assert facts["worker_bytes"] < 4 * 2**30
    refused = CliRunner().invoke(main, ["explain", "edge", "--engine", "processes"])
    assert refused.exit_code == 2
    assert "edge is a template; a program wanted" in refused.output
