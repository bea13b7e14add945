"""A newcomer's first run compiles for a minute: stderr says so once, a pipe with JSON hears nothing."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cnnsim import write_picture
from cnnsim.support.notices import Notice


def test_it_is_said_once_and_only_when_something_is_compiled() -> None:
    said: list[str] = []
    notice = Notice(lambda: said.append("compiling"))
    assert not said
    for _ in range(3):
        for event in (notice.on_start, notice.on_start, notice.on_end, notice.on_end):  # passes run passes
            event()
    assert said == ["compiling"]


def test_a_terminal_is_told_where_the_loops_are_kept(tmp_path: Path) -> None:
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
    (kept,) = (tmp_path / "cache").glob("*.closed_form.*.loop")
    kept.unlink()
    piped = subprocess.run(command, env=where, capture_output=True, check=True)  # compiles one anew, into pipes
    assert piped.stderr == b""
    kept.unlink()
    plain = subprocess.run(command[:-1], env=where, capture_output=True, check=True)
    assert plain.stderr.decode() == f"compiling loops, once, for a minute or so; kept in {tmp_path / 'cache'}\n"
    assert b"compiling" not in plain.stdout
    assert kept.exists()
    for end in (ours, theirs):
        os.close(end)
