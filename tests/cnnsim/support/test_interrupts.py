"""Ctrl-C during a compilation: it is handled, the function is complete, and a second one ends a command at once."""

import os
import subprocess
import sys

import pytest

from tests.kits.paths import ROOT

COMPILING = """
import signal, sys
from llvmlite.binding.executionengine import ExecutionEngine

kind, presses = sys.argv[1], int(sys.argv[2])
left = [0]

def press(*_):
    while left[0]:
        left[0] -= 1
        signal.raise_signal(signal.SIGINT)

def with_press(self, notified=None, *more, of=ExecutionEngine.set_object_cache):
    def pressed(*given):
        press()
        notified(*given)
    of(self, pressed, *more)

if kind == "callback":  # within a call from LLVM, where Python loses what is raised
    ExecutionEngine.set_object_cache = with_press

from numba.core import event
from cnnsim.support.compiled_loops import kept_njit
from cnnsim.support.interrupts import Stopping

class Pass(event.Listener):
    on_start = press
    def on_end(self, _): pass

if kind == "pass":
    event.register("numba:run_pass", Pass())
Stopping.command_line = True

@kept_njit()
def double(x):
    return x + x

left[0] = presses
try:
    double(2)
    print("not heard")
except KeyboardInterrupt:
    print("heard", double(2), signal.getsignal(signal.SIGINT) is signal.default_int_handler)
"""

FOREIGN = """
import atexit
import click
from cnnsim.support.command_line import CommandGroup
from cnnsim.support.interrupts import foreign_call

@click.group(cls=CommandGroup)
def main(): pass

call = foreign_call()

@main.command()
def wait():
    call.__enter__()  # a compiler's thread that goes on
    print("told")
    raise KeyboardInterrupt

atexit.register(print, "torn down beneath it")
main(["wait"])
"""


def python(code: str, *words: str, folder: object) -> "subprocess.CompletedProcess[str]":
    env = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder)}
    file = f"{folder}/code.py"
    with open(file, "w", encoding="utf-8") as written:  # noqa: PTH123 - numba keeps nothing of code without a file
        written.write(code)
    return subprocess.run(
        [sys.executable, file, *words], env=env, capture_output=True, text=True, check=False, timeout=120
    )


@pytest.mark.parametrize("kind", ["pass", "callback"])
def test_a_stop_while_compiling_is_heard_and_the_next_call_compiles(kind: str, tmp_path: object) -> None:
    done = python(COMPILING, kind, "1", folder=tmp_path)
    assert done.stdout.split() == ["heard", "4", "True"], done.stderr
    assert not done.stderr


def test_the_second_stop_while_compiling_ends_a_command_at_once(tmp_path: object) -> None:
    done = python(COMPILING, "callback", "2", folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_a_command_does_not_wait_for_a_foreign_compiler_nor_take_its_library_away(tmp_path: object) -> None:
    done = python(FOREIGN, folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (130, "told\n", "stopped\n")
