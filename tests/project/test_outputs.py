"""Outputs on a full disk, on a folder, on a file where a folder is wanted: one line, nothing half-written."""

import os
import resource
import subprocess
import sys
from contextlib import chdir
from pathlib import Path
from shutil import rmtree

import numpy as np
import pytest
from click.testing import CliRunner, Result

from cnnsim.cli.group import main as cnnsim
from cnnsim.support.pictures.picture import write_picture
from tactile.cli.group import main as tactile
from tests.kits.paths import ROOT, SCENES

GROUPS = {"cnnsim": cnnsim, "tactile": tactile}
COMMANDS = {
    "run": ["cnnsim", "run", "edge", "p.png", "--backend", "reference", "-o", "OUT.png"],
    "program": ["cnnsim", "program", "opening", "--input", "picture=p.png", "--replace", "-o", "OUT"],
    "export": ["cnnsim", "export", "edge", "--format", "json", "--replace", "-o", "OUT"],
    "record": ["tactile", "run", "s.toml", "--replace", "-o", "OUT"],
    "convert": ["tactile", "convert", "s.toml", "OUT.npz"],
    "csv": ["tactile", "convert", "s.toml", "OUT.csv"],
}  # fmt: skip
FOLDERS = {name for name, words in COMMANDS.items() if words[-1] == "OUT"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_picture(np.where(np.add.outer(range(64), range(64)) % 7 > 3, 1.0, -1.0), tmp_path / "p.png")
    scene = (SCENES / "grip.toml").read_text(encoding="utf-8")
    (tmp_path / "s.toml").write_text(
        "\n".join("duration_s = 0.3" if line.startswith("duration_s") else line for line in scene.splitlines()),
        encoding="utf-8",
    )
    (tmp_path / "work").mkdir()
    return tmp_path


def words_of(name: str) -> list[str]:
    return [word.replace("OUT", "work/out") for word in COMMANDS[name]]


def call(folder: Path, name: str) -> Result:
    group, *words = words_of(name)
    with chdir(folder):
        return CliRunner().invoke(GROUPS[group], words)


def call_limited(folder: Path, name: str, most: int) -> "subprocess.CompletedProcess[str]":
    """Call a command in a process whose files have at most ``most`` bytes."""
    group, *words = words_of(name)
    code = f"from {group}.cli.group import main; main()"
    env = {**os.environ, "PYTHONPATH": str(ROOT), "MPLCONFIGDIR": str(folder)}
    env["PYTHONDONTWRITEBYTECODE"] = "1"  # Python keeps modules cut off, and finds no other module there later
    return subprocess.run(
        [sys.executable, "-c", code, *words], cwd=folder, env=env, capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
    )  # fmt: skip


def assert_refused(code: int, stderr: str) -> None:
    assert code == 2, stderr
    assert "Traceback" not in stderr
    assert sum("rror" in line for line in stderr.splitlines()) == 1, stderr


@pytest.mark.parametrize("name", ["run", "record", "convert", "export"])
def test_a_disk_that_is_full_leaves_nothing_half_written(name: str, folder: Path) -> None:
    """A limit on the size of files stands for it: the system refuses what is beyond."""
    if name == "record":
        assert call(folder, name).exit_code == 0  # its loops are compiled now, and kept
        rmtree(folder / "work" / "out")
    done = call_limited(folder, name, {"run": 60, "export": 10}.get(name, 300))
    assert_refused(done.returncode, done.stderr)
    left = [path for path in (folder / "work").rglob("*") if path.is_file()]
    assert left == []


@pytest.mark.parametrize("name", ["program", "export", "record", "csv"])
def test_a_file_where_a_folder_is_wanted_and_the_reverse(name: str, folder: Path) -> None:
    target = folder / "work" / ("out" if name in FOLDERS else "out.csv")
    if name in FOLDERS:
        target.write_text("mine", encoding="utf-8")
    else:
        target.mkdir()
    done = call(folder, name)
    assert_refused(done.exit_code, done.stderr)
    assert target.read_text(encoding="utf-8") == "mine" if name in FOLDERS else not list(target.iterdir())


@pytest.mark.parametrize(
    ("name", "file"), [("program", "opened.png"), ("export", "edge.json"), ("record", "frames.csv")]
)
def test_a_link_in_the_folder_is_not_followed(name: str, file: str, folder: Path) -> None:
    (folder / "precious").write_text("mine", encoding="utf-8")
    (folder / "work" / "out").mkdir()
    link = folder / "work" / "out" / file
    link.symlink_to(folder / "precious")
    done = call(folder, name)
    assert done.exit_code == 0, done.stderr
    assert (folder / "precious").read_text(encoding="utf-8") == "mine"
    assert link.is_file(), list(link.parent.iterdir())
    assert not link.is_symlink()
