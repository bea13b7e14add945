"""No file, however broken or hostile, ends in a traceback, takes 5 seconds or a gigabyte."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim.cli.group import main as cnnsim
from cnnsim.support import InputError
from cnnsim.support.bounds import TAXELS, check_unpacked
from cnnsim.support.pictures.picture import write_picture
from tactile.cli.group import main as tactile
from tactile.core.frame import TaxelArray
from tests.kits.paths import ROOT, SCENES


def test_all_readers_take_all_broken_files() -> None:
    """In a process of its own, whose memory the system bounds."""
    done = subprocess.run([sys.executable, "-m", "tests.fuzz.readers", "3"], cwd=ROOT, capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    assert not found["bad"], "\n".join(found["bad"][:20])
    assert set(found["seen"]) >= {".toml", ".npz", ".npy", ".csv", ".parquet", ".mcap", ".bag", ".m", ".json", ".png"}
    assert sum(found["seen"].values()) > 1500


@pytest.mark.parametrize("command", [
    ["cnnsim", "run", "edge", "p.png", "--step", "1e-300"], ["cnnsim", "run", "edge", "p.png", "--step", "nan"],
    ["cnnsim", "run", "edge", "p.png", "--time", "1e308"], ["cnnsim", "run", "diffusion", "p.png", "--step", "1e308"],
    ["cnnsim", "run", "edge", "p.png", "--boundary", "fixed:1e999"],
    ["cnnsim", "explain", "edge", "--size", "9e9x9"], ["cnnsim", "program", "p.png"],
    ["tactile", "run", "grip.toml", "--window", "1000000000"], ["tactile", "run", "grip.toml", "--window", "1e9"],
    ["tactile", "run", "p.png"], ["tactile", "convert", "p.png", "x.csv"], ["tactile", "calibrate", "p.png",
     "--speed-mm-s", "1", "--load-n", "1"], ["tactile", "explain", "p.png"], ["tactile", "replay", "p.png"],
])  # fmt: skip
def test_numbers_and_files_of_another_kind_end_in_one_line(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_picture(np.ones((4, 4)), tmp_path / "p.png")
    (tmp_path / "grip.toml").write_bytes((SCENES / "grip.toml").read_bytes())
    result = CliRunner().invoke({"cnnsim": cnnsim, "tactile": tactile}[command[0]], command[1:])
    assert result.exit_code == 2, result.output
    assert "Error" in result.stderr
    assert "Traceback" not in result.output


def test_a_message_is_a_line_of_bounded_length(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(f'title = 1\nseed = "{"x" * 50_000}"\n{"y" * 5000} = 1\n', encoding="utf-8")
    result = CliRunner().invoke(tactile, ["run", str(tmp_path / "s.toml")])
    assert result.exit_code == 2
    assert len(result.stderr) < 1100
    assert result.stderr.count("\n") == 1


def test_bounds_are_said_with_both_numbers(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"257 x 256 taxels: 65792; {TAXELS} at most wanted"):
        TaxelArray("tip", 257, 256, 1e-3, 1e-3)
    (tmp_path / "small").write_bytes(b"x" * 1000)
    check_unpacked(tmp_path / "small", 60_000_000)
    with pytest.raises(InputError, match="1000 bytes that unpack to 70000000; 200 times as many at most wanted"):
        check_unpacked(tmp_path / "small", 70_000_000)


def test_a_pipe_and_an_empty_file_in_a_library_do_not_stop_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "programs").mkdir()
    os.mkfifo(tmp_path / "programs" / "pipe.toml")
    (tmp_path / "empty.toml").touch()
    (tmp_path / "programs" / "empty.toml").touch()
    for more in ([], ["--programs"], ["--json"]):
        result = CliRunner().invoke(cnnsim, ["--library", str(tmp_path), "list", *more])
        assert result.exit_code == 0, result.output
        assert "edge" in result.stdout or "opening" in result.stdout
        assert "empty.toml" in result.output
