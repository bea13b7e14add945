"""Commands on streams that are closed, full, or know no letters but ASCII."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PLAIN = {**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "80"}


def ends(arguments: str, shell: str, where: Path) -> "subprocess.CompletedProcess[str]":
    command = f"{sys.executable} -m cnnsim {arguments} {shell}"
    return subprocess.run(command, shell=True, capture_output=True, text=True, env=PLAIN, cwd=where, check=False)


def test_letters_that_stdout_cannot_write(tmp_path: Path) -> None:
    """Texts of users' own files have any letters: those that are missing are ?."""
    (tmp_path / "naïve.toml").write_text('name = "naive"\nA = 3\n', encoding="utf-8")
    found = ends("--library . list --json", "", tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert "na?ve.toml" in found.stdout or "na\\u00efve.toml" in found.stdout
    found = ends("--library . list", "", tmp_path)
    assert found.returncode == 0
    assert "Traceback" not in found.stderr


def test_stderr_that_is_closed(tmp_path: Path) -> None:
    found = ends("list --tag motion", "2>&-", tmp_path)
    assert found.returncode == 0
    assert found.stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_under_json(tmp_path: Path) -> None:
    found = ends("list --json", ">/dev/full", tmp_path)
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1
    assert "No space left" in found.stderr
