"""Programs that tests start as users do; they end with the tests, also where those are killed."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

END_WITH_PARENT = """
import ctypes, os, signal, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    os.getppid() == {parent} or os._exit(1)  # it died before that
"""


def code_line(code: str) -> list[str]:
    """The command that runs Python code until its end or that of the process that starts it."""
    return [sys.executable, "-c", END_WITH_PARENT.format(parent=os.getpid()) + code]


def command_line(program: str, *arguments: Any) -> list[str]:
    """The command that runs ``cnnsim`` or ``tactile`` so."""
    return [*code_line(f"from {program}.cli.start import main; main()"), *(str(argument) for argument in arguments)]


@contextmanager
def ended(process: "subprocess.Popen[str]") -> "Iterator[subprocess.Popen[str]]":
    """A process that has ended when the block has, whatever happens there."""
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()


def start(*arguments: Any) -> "subprocess.Popen[str]":
    """Start a command of `tactile` beside the test."""
    return subprocess.Popen(
        command_line("tactile", *arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL, text=True,
    )  # fmt: skip
