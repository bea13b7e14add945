"""Commands on streams that are closed, full, or know no letters but ASCII."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kits.paths import ROOT

PLAIN = {**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "80", "PYTHONUNBUFFERED": ""}


def ends(arguments: str, shell: str, where: Path) -> "subprocess.CompletedProcess[str]":
    command = f"{sys.executable} -m {arguments} {shell}"
    return subprocess.run(command, shell=True, capture_output=True, text=True, env=PLAIN, cwd=where, check=False)


def test_letters_that_stdout_cannot_write(tmp_path: Path) -> None:
    """The table of events has arrows."""
    found = ends(f"tactile run {shlex.quote(str(ROOT / 'examples' / 'grasp.npz'))}", "", tmp_path)
    assert (found.returncode, "Traceback" in found.stderr) == (0, False)
    assert "contact" in found.stdout
    assert "?" in found.stdout


def test_stderr_that_is_closed(tmp_path: Path) -> None:
    found = ends("cnnsim list --tag motion", "2>&-", tmp_path)
    assert found.returncode == 0
    assert found.stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize("command", ["cnnsim --help", "cnnsim --version", "tactile --help", "cnnsim list --help"])
def test_a_full_disk_under_help(command: str, tmp_path: Path) -> None:
    found = ends(command, ">/dev/full", tmp_path)
    assert found.returncode == 2
    assert found.stderr == "Error: the system: No space left on device\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_under_json(tmp_path: Path) -> None:
    found = ends("cnnsim list --json", ">/dev/full", tmp_path)
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1
    assert "No space left" in found.stderr
