"""Ctrl-C ends a sweep and its workers with one line and no traceback."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.kits.processes import command_line, ended

STUDY = """
kind = "transients"
[grid]
template = ["hole-filler", "edge"]
seed = { from = 0, count = 3000 }
[fixed]
rows = 40
cols = 40
"""


def workers_of(process: int) -> list[str]:
    """The command lines of the worker processes that a process has started."""
    found = []
    for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
        try:
            found.append(Path(f"/proc/{child}/cmdline").read_text())
        except OSError:
            continue  # has ended
    return [line for line in found if "spawn_main" in line]


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
def test_ctrl_c_while_workers_start_ends_all_of_them(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    command = command_line("cnnsim", "sweep", "study.toml", "-o", "out", "--workers", 2)
    begun = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    with ended(begun) as sweep:
        until = time.monotonic() + 60
        while not workers_of(sweep.pid) and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.05)
        os.killpg(sweep.pid, signal.SIGINT)
        _, said = sweep.communicate(timeout=60)
    assert said.replace("stopped\n", "", 1) == ""
    assert sweep.returncode == 130
