"""PoCL's cache of kernels: what is not as it was is dropped, and after a process that ended hard what nobody knows."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kits.opencl import cl
from tests.kits.paths import ROOT

from cnnsim.backends.opencl.device import pocl_cache  # isort: skip  # skipped where there is no OpenCL

CODE = """
import numpy as np
from cnnsim import run
print(int((run("edge", 2 * np.eye(9) - 1, backend="opencl", duration=1.0).y > 0).sum()))
"""


def entry(folder: Path, name: str) -> Path:
    file = folder / name[:2] / name[2:] / "kernel" / "1-1-1" / "kernel.so"
    file.parent.mkdir(parents=True)
    file.write_bytes(b"code")
    return file


def leave(folder: Path) -> None:
    pocl_cache._leave(folder, folder / "none")


def test_a_changed_file_takes_its_program_away(tmp_path: Path) -> None:
    good, cut = entry(tmp_path, "ABCD"), entry(tmp_path, "EFGH")
    leave(tmp_path)
    unknown = entry(tmp_path, "IJKL")
    cut.write_bytes(b"co")
    pocl_cache.drop_damaged(tmp_path)
    assert good.exists()
    assert unknown.exists()
    assert not (tmp_path / "EF" / "GH").exists()


def test_after_a_hard_end_what_is_unknown_goes(tmp_path: Path) -> None:
    good = entry(tmp_path, "ABCD")
    leave(tmp_path)
    unknown = entry(tmp_path, "IJKL")
    busy = tmp_path / "cnnsim-busy-999999999"
    busy.touch()
    alive = tmp_path / f"cnnsim-busy-{os.getpid()}"
    alive.touch()
    pocl_cache.drop_damaged(tmp_path)
    assert unknown.exists()  # another process may be at it
    assert not busy.exists()
    alive.unlink()
    busy.touch()
    pocl_cache.drop_damaged(tmp_path)
    assert good.exists()
    assert not unknown.exists()


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"a": 1}', "null"])
def test_a_damaged_list_is_no_list(tmp_path: Path, text: str) -> None:
    good = entry(tmp_path, "ABCD")
    (tmp_path / pocl_cache.LIST).write_text(text)
    pocl_cache.drop_damaged(tmp_path)
    assert good.exists()


@pytest.mark.skipif(
    not any(platform.name == "Portable Computing Language" for platform in cl.get_platforms()), reason="no PoCL here"
)
def test_a_damaged_cache_is_made_anew(tmp_path: Path) -> None:
    folder = tmp_path / "kernels"

    def run() -> subprocess.CompletedProcess[str]:
        env = {**os.environ, "POCL_CACHE_DIR": str(folder), "PYTHONPATH": str(ROOT)}
        return subprocess.run([sys.executable, "-c", CODE], env=env, capture_output=True, text=True, check=False)

    first = run()
    assert first.returncode == 0, first.stderr
    files = [*folder.rglob("*.so"), *folder.rglob("*.bc")]
    assert files
    for file in files:
        file.write_bytes(file.read_bytes()[:100])
    again = run()
    assert (again.returncode, again.stdout, again.stderr) == (0, first.stdout, "")
