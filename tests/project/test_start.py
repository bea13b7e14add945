"""Ctrl-C while a command is still importing: one line and exit code 130, at any point of the import."""

import os
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.kits.example_files import PICTURE, SCENE
from tests.kits.paths import ROOT
from tests.kits.processes import END_WITH_PARENT, ended

HALT = """
import os, sys, time

class Halt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            sys.meta_path.remove(self)
            os.write(1, b"there")
            time.sleep(60)

sys.meta_path.insert(0, Halt())
"""
"""Stands still where a module is about to be imported, and says so."""

SCRIPTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
COMMANDS = {"cnnsim": ["run", "edge", str(PICTURE), "-o", "edge.png"], "tactile": ["run", str(SCENE)]}


def script(program: str) -> str:
    """Return what an installed script does."""
    module, function = SCRIPTS[program].split(":")
    return f"from {module} import {function}\nsys.exit({function}())"


def module(program: str) -> str:
    """Return what ``python -m`` does."""
    return f"import runpy\nrunpy.run_module({program!r}, run_name='__main__', alter_sys=True)"


@pytest.mark.parametrize(("program", "way", "halt"), [
    ("cnnsim", script, "cnnsim.cli.group"), ("cnnsim", script, "numba"), ("cnnsim", module, "numpy"),
    ("tactile", script, "numpy"), ("tactile", module, "tactile.cli.group"),
])  # fmt: skip
def test_a_stop_while_a_command_imports_is_one_line_and_130(
    program: str, way: Callable[[str], str], halt: str, tmp_path: Path
) -> None:
    halting = HALT.format(name=halt)
    code = END_WITH_PARENT.format(parent=os.getpid()) + halting + way(program)
    with ended(subprocess.Popen(
        [sys.executable, "-c", code, *COMMANDS[program]], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stdout.read(5) == "there"
        process.send_signal(signal.SIGINT)
        told, warned = process.communicate(timeout=30)
        assert (process.returncode, told, warned) == (130, "", "stopped\n")


def test_a_signal_that_is_ignored_stays_so() -> None:
    """As that of a command that a shell runs in the background."""
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from cnnsim.start import end_at_once, raise_again\n"
        "for act in (end_at_once, raise_again): act(); print(signal.getsignal(signal.SIGINT).name)\n"
    )
    told = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert told.split() == ["SIG_IGN", "SIG_IGN"]


TERMINATED = """
import os, signal, sys, time, types
import click
from cnnsim.start import start
from cnnsim.support.command_line import CommandGroup
from cnnsim.support.files import writing

def write():
    with writing("x") as temporary:
        temporary.write_text("half")
        os.kill(os.getpid(), int(sys.argv[1]))
        time.sleep(9)

signal.signal(signal.SIGINT, int(sys.argv[2]) or signal.default_int_handler)
group = CommandGroup(commands={"write": click.Command("write", callback=write)})
sys.modules["group"] = types.SimpleNamespace(main=lambda prog_name: group.main(["write"]))
start("group")
"""


@pytest.mark.parametrize(("number", "ignored"), [(signal.SIGTERM, 0), (signal.SIGTERM, 1), (signal.SIGHUP, 0)])
def test_a_terminated_command_cleans_up(number: signal.Signals, ignored: int, tmp_path: Path) -> None:
    """Also where Ctrl-C is ignored (1 is SIG_IGN), as of jobs in the background."""
    words = [sys.executable, "-c", TERMINATED, str(int(number)), str(ignored)]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, "", "stopped\n")
    assert list(tmp_path.iterdir()) == []
