"""Programs run as child processes, which end with the test process, and waiting for a condition."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

END_WITH_PARENT = """
import ctypes, os, signal, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    os.getppid() == {parent} or os._exit(1)  # the parent has already died
"""


def code_line(code: str) -> list[str]:
    """Return the command that runs Python code, and is killed when the calling process ends."""
    return [sys.executable, "-c", END_WITH_PARENT.format(parent=os.getpid()) + code]


def command_line(program: str, *arguments: Any) -> list[str]:
    """Return the command that runs ``cnnsim`` or ``tactile`` in the same way."""
    return [*code_line(f"from {program}.cli.start import main; main()"), *(str(argument) for argument in arguments)]


@contextmanager
def ended(process: "subprocess.Popen[str]") -> "Iterator[subprocess.Popen[str]]":
    """Kill a process at the end of the block if it still runs."""
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()


def start(*arguments: Any) -> "subprocess.Popen[str]":
    """Start a command of `tactile` in the background."""
    return subprocess.Popen(
        command_line("tactile", *arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL, text=True,
    )  # fmt: skip


def wait_until(condition: Callable[[], bool], seconds: float = 20.0) -> None:
    """Wait until a condition holds, and fail after some seconds."""
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.01)
