"""A newcomer's first run compiles for a minute: stderr says so once, unless JSON goes to a pipe."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cnnsim import write_picture


def test_a_terminal_shows_where_the_loops_are_kept_and_a_pipe_of_json_nothing(tmp_path: Path) -> None:
    write_picture(np.eye(20), tmp_path / "in.png")  # few cells: loops on several threads take twice as long to compile
    command = [
        sys.executable,
        "-c",
        "from cnnsim.cli.group import main; main()",
        "run",
        "edge",
        str(tmp_path / "in.png"),
        "--json",
    ]
    ours, theirs = pty.openpty()
    os.set_blocking(ours, False)
    where = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    ran = subprocess.run(command, env=where, stdout=subprocess.PIPE, stderr=theirs, check=True)
    said = os.read(ours, 10_000).decode()
    assert said.count("compiling") == 1
    assert str(tmp_path / "cache") in said
    assert b"compiling" not in ran.stdout
    again = subprocess.run(command, env=where, stdout=subprocess.PIPE, stderr=theirs, check=True)  # from the cache
    with pytest.raises(BlockingIOError):  # nothing was said
        os.read(ours, 10_000)
    assert again.stdout == ran.stdout
    (kept,) = (tmp_path / "cache").glob("*.closed_form-*.nbc")
    kept.unlink()
    piped = subprocess.run(
        command, env=where, capture_output=True, check=True
    )  # compiles a loop again, with pipes as outputs
    assert piped.stderr == b""
    kept.unlink()
    plain = subprocess.run(command[:-1], env=where, capture_output=True, check=True)
    assert plain.stderr.decode() == f"compiling loops, once, for a minute or so; kept in {tmp_path / 'cache'}\n"
    assert b"compiling" not in plain.stdout
    assert kept.exists()
    for end in (ours, theirs):
        os.close(end)
