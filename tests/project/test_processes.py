"""Programs that tests start end with them."""

import signal
import subprocess
import sys

import pytest

from tests.kits.paths import ROOT
from tests.kits.processes import code_line

TESTS = """
import subprocess, sys
from tests.kits.processes import code_line
subprocess.Popen(code_line("print('here', flush=True); import time; time.sleep(60)")).wait()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a process of its parent's end")
def test_a_program_ends_when_the_tests_are_killed() -> None:
    with subprocess.Popen([sys.executable, "-c", TESTS], cwd=ROOT, stdout=subprocess.PIPE, text=True) as tests:
        assert tests.stdout is not None
        assert tests.stdout.readline() == "here\n"
        tests.send_signal(signal.SIGKILL)
        rest, _ = tests.communicate(timeout=5)  # the end of the pipe: nobody has it open any more
    assert rest == ""


def test_a_program_whose_parent_is_gone_does_nothing() -> None:
    command = code_line("print('here')")
    command[-1] = command[-1].replace("os.getppid()", "-1")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("", 1) if sys.platform == "linux" else done.stdout
