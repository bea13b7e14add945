"""Environments that libraries cannot use: one line and exit code 2 before anything is imported."""

import os
import resource
import subprocess
import sys

import pytest

from cnnsim.start import environment_fault
from tests.kits.paths import ROOT


@pytest.mark.parametrize(("name", "value", "wanted"), [
    ("NUMBA_NUM_THREADS", "0", "'0'; a whole number above 0"), ("NUMBA_NUM_THREADS", "abc", "a whole number above 0"),
    ("NUMBA_NUM_THREADS", "2.5", "a whole number above 0"), ("NUMBA_NUM_THREADS", "", "a whole number above 0"),
    ("NUMBA_THREADING_LAYER", "none", "one of default, safe"), ("NUMBA_DISABLE_JIT", "1", "0 wanted"),
])  # fmt: skip
def test_numbas_variables_are_checked(monkeypatch: pytest.MonkeyPatch, name: str, value: str, wanted: str) -> None:
    assert environment_fault() is None
    monkeypatch.setenv(name, value)
    assert wanted in str(environment_fault())


def test_a_command_in_a_small_address_space_ends_with_one_line() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "cnnsim", "list"], cwd=ROOT, capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (500_000_000, resource.RLIM_INFINITY)),
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "Error: 500 MB of address space (ulimit -v); 1000 MB at least wanted\n"


def test_a_matplotlib_backend_of_a_notebook_does_not_reach_a_command() -> None:
    code = "import sys, cnnsim.start as s, os; s.import_module = lambda _: sys; sys.main = lambda prog_name: None; "
    code += "s.start('x'); import matplotlib; print(matplotlib.get_backend())"
    env = {**os.environ, "MPLBACKEND": "module://nowhere"}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("agg\n", 0), done.stderr
