"""Workers with an OpenCL device each: PoCL can be configured to show several devices."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cnnsim.backends.opencl.device.devices import own_device
from tests.kits.paths import ROOT

RUN = """
import json, sys
import numpy as np
import cnnsim
from cnnsim.supersteps.engine import Engine

if __name__ == '__main__':  # workers import this file
    x = np.random.default_rng(3).uniform(-1, 1, (96, 96)).astype("f4")
    template = cnnsim.Template([[0, 0.2, 0], [0.2, 1.4, 0.2], [0, 0.2, 0]], 0.0, 0.1)
    task = dict(state=x, duration=1.0, backend="opencl", dtype="float32")
    whole = cnnsim.run_transient(template, **task)
    parts = cnnsim.run_transient(template, **task, engine=Engine(workers=int(sys.argv[1]), side=16, depth=2))
    print(json.dumps([bool(np.array_equal(whole.x, parts.x)), dict(parts.plan.decisions)]))
"""


ENVIRONMENT = {**os.environ, "POCL_DEVICES": "pthread pthread", "PYTHONPATH": str(ROOT)}


def test_each_worker_computes_on_a_device_of_its_own(tmp_path: Path) -> None:
    pytest.importorskip("pyopencl")
    pytest.importorskip("zarr")
    (tmp_path / "run.py").write_text(RUN)
    run = [sys.executable, str(tmp_path / "run.py"), "2"]
    same, decisions = json.loads(subprocess.run(run, env=ENVIRONMENT, capture_output=True, check=True).stdout)
    assert same
    assert decisions["engine"] == "processes: 2 workers, blocks of 16 x 16 cells"
    assert decisions["devices"].startswith("0: pthread")
    assert "; 1: pthread" in decisions["devices"]


def test_a_device_that_the_environment_names_is_everybodys(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyopencl")
    monkeypatch.setenv("CNNSIM_DEVICE", "0")
    assert own_device.__wrapped__() is None


def test_more_processes_than_devices_take_turns_and_leave_theirs_when_they_die(tmp_path: Path) -> None:
    pytest.importorskip("pyopencl")
    code = "from cnnsim.backends.opencl.device.devices import own_device; print(own_device(), flush=True); input()"
    environment = ENVIRONMENT | {"XDG_CACHE_HOME": str(tmp_path)}  # no other process claims devices here
    started: list[subprocess.Popen[str]] = []

    def start() -> str:
        started.append(subprocess.Popen([sys.executable, "-c", code], env=environment, text=True, stdin=-1, stdout=-1))
        out = started[-1].stdout
        assert out is not None
        return out.readline().strip()

    try:
        assert [start() for _ in range(3)] == ["0", "1", "0"]
        started[1].kill()
        started[1].wait()
        assert start() == "1"
    finally:
        for process in started:
            process.kill()
            process.communicate()
