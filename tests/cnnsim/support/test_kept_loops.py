"""Compiled loops on disk: damaged files are made anew, what others can write is not used, forks go on alone."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cnnsim.support import kept_loops
from cnnsim.support.kept_loops import kept_njit
from cnnsim.support.private_folder import Notices
from tests.kits.paths import ROOT

TEMPLATE = """
from cnnsim.support.kept_loops import folder, kept_njit

@kept_njit(error_model="numpy")
def double(x):
    return x + x

assert double(21) == 42
hits = sum(double.stats.cache_hits.values())
print(folder(), hits)
"""


def run(cache: Path | None, code: str = TEMPLATE, **variables: str) -> tuple[Path, int, str]:
    env = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    if cache is not None:
        env["NUMBA_CACHE_DIR"] = str(cache)
    file = (cache or Path(variables["HOME"])) / "double.py"
    file.parent.mkdir(exist_ok=True, mode=0o700)
    file.write_text(code)
    done = subprocess.run([sys.executable, file], env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    folder, hits = done.stdout.split()
    return Path(folder), int(hits), done.stderr


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    return tmp_path / "loops"


def test_loops_are_compiled_once(cache: Path) -> None:
    assert run(cache)[:2] == (cache, 0)
    assert run(cache) == (cache, 1, "")


@pytest.mark.parametrize("damage", ["empty", "cut", "garbage", "one bit", "text"])
def test_a_damaged_file_is_noticed_and_made_anew(cache: Path, damage: str) -> None:
    run(cache)
    (file,) = cache.glob("*.loop")
    raw = bytearray(file.read_bytes())
    raw[len(raw) // 2] ^= 1
    cut = bytes(raw[: len(raw) // 3])
    kinds = {"empty": b"", "cut": cut, "garbage": os.urandom(5000), "one bit": bytes(raw), "text": b"no loop"}
    file.write_bytes(kinds[damage])
    assert run(cache) == (cache, 0, "")
    assert run(cache) == (cache, 1, "")


@pytest.mark.parametrize("mode", [0o770, 0o777])
def test_a_folder_that_others_can_write_is_not_used_and_said_once(cache: Path, mode: int) -> None:
    cache.mkdir()
    cache.chmod(mode)
    folder, hits, told = run(cache)
    assert folder != cache
    assert not hits
    assert told.count("others can write") == 1
    assert not list(cache.glob("*.loop"))


def test_a_file_that_others_can_write_is_not_used(cache: Path) -> None:
    run(cache)
    (file,) = cache.glob("*.loop")
    file.chmod(0o666)
    assert run(cache)[1] == 0


def test_a_folder_that_cannot_be_used_is_a_word_and_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever is root can write everywhere, so a file stands where the folder should be."""
    wall = tmp_path / "file"
    wall.write_text("")
    told: list[str] = []
    monkeypatch.setattr(Notices, "tell", told.append)
    monkeypatch.setattr(Notices, "_told", set())
    from cnnsim.support.private_folder import first_usable

    folder = first_usable([wall / "a", wall], "compiled loops")
    assert folder.is_dir()
    assert first_usable([wall / "a", wall], "compiled loops") != wall
    assert len(told) == 1
    assert "made anew" in told[0]
    assert str(wall) in told[0]


def test_a_full_disk_keeps_nothing_and_stops_nothing(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("this system has no /dev/full")
    cache.mkdir(mode=0o700)
    monkeypatch.setattr(kept_loops, "folder", lambda: cache)
    new = cache / "new"
    new.write_text("")
    monkeypatch.setattr("tempfile.mkstemp", lambda **_: (os.open(full, os.O_WRONLY), str(new)))

    @kept_njit()
    def triple(x: int) -> int:
        return 3 * x

    assert triple(4) == 12
    assert not list(cache.glob("*.loop"))
    assert not new.exists()


FORK = """
import os, sys
import numpy as np
from cnnsim import InputError, run
picture = np.where(np.random.default_rng(0).random((200, 200)) < 0.5, 1.0, -1.0)
backend = sys.argv[1]
ours = run("hole-filler", picture, backend=backend, duration=1.0).y
child = os.fork()
if child == 0:
    code = 3
    try:
        theirs = run("hole-filler", picture, backend=backend, duration=1.0).y
        code = 0 if np.array_equal(ours, theirs) else 4
    except InputError as error:
        code = 5 if "spawn" in str(error) else 6
    os._exit(code)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.parametrize(("backend", "code"), [("cpu", 0), ("opencl", 5)])
def test_a_child_after_use_computes_or_names_spawn(backend: str, code: int) -> None:
    if backend == "opencl":
        from tests.kits import opencl  # noqa: F401 - skips where there is none
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORK, backend],
        env=env, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.stdout.split() == [str(code)], done.stderr
