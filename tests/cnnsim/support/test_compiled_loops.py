"""Compiled loops on disk: what is damaged or out of date is compiled again, folders of others are not used."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from cnnsim.support import compiled_loops
from cnnsim.support.cache_folder import first_usable, is_private
from cnnsim.support.notices import Notices
from tests.kits.paths import ROOT

TEMPLATE = """
from cnnsim.support.compiled_loops import folder, kept_njit

@kept_njit(error_model="numpy")
def double(x):
    return x + x

assert double(21) == 42
hits = sum(double.stats.cache_hits.values())
print(folder(), hits)
"""


def run(cache: Path | None, code: str = TEMPLATE, *, full: bool = False, **variables: str) -> tuple[Path, int, str]:
    env = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    if cache is not None:
        env["NUMBA_CACHE_DIR"] = str(cache)
    file = (cache or Path(variables["HOME"])) / "double.py"
    file.parent.mkdir(exist_ok=True, mode=0o700)
    file.write_text(code)
    limit = (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))) if full else None
    if full:
        env["PYTHONDONTWRITEBYTECODE"] = "1"  # modules would be kept cut off
    done = subprocess.run(
        [sys.executable, file], env=env, capture_output=True, text=True, check=False, preexec_fn=limit
    )
    assert done.returncode == 0, done.stderr
    folder, hits = done.stdout.split()
    return Path(folder), int(hits), done.stderr


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    return tmp_path / "loops"


def test_loops_are_compiled_once(cache: Path) -> None:
    assert run(cache)[:2] == (cache, 0)
    assert run(cache) == (cache, 1, "")


def test_options_in_a_set_have_no_order(cache: Path) -> None:
    code = TEMPLATE.replace('error_model="numpy"', 'fastmath={"contract", "reassoc", "nsz"}')
    assert [run(cache, code, PYTHONHASHSEED=seed)[1] for seed in "12"] == [0, 1]


def test_a_full_disk_keeps_nothing_and_stops_nothing(cache: Path) -> None:
    """A limit on the size of files stands for it."""
    place, hits, told = run(cache, full=True)
    assert (place != cache, hits) == (True, 0)
    assert "loops are compiled again each time" in told


@pytest.mark.parametrize("kept", ["*.nbc", "*.nbi"])
@pytest.mark.parametrize("damage", [b"", os.urandom(5000)], ids=["empty", "garbage"])
def test_a_damaged_file_is_compiled_again(cache: Path, damage: bytes, kept: str) -> None:
    run(cache)
    (file,) = cache.glob(kept)
    file.write_bytes(damage)
    assert run(cache) == (cache, 0, "")
    assert run(cache) == (cache, 1, "")


def test_a_folder_that_others_can_write_is_left_in_silence_for_one_of_the_users_own(cache: Path) -> None:
    cache.mkdir()
    cache.chmod(0o777)
    folder, hits, told = run(cache)
    assert folder != cache
    assert not hits
    assert told == ""
    assert not list(cache.glob("*.nbc"))


@pytest.mark.parametrize(("mode", "private"), [(0o700, True), (0o755, True), (0o775, False), (0o757, False)])
def test_a_private_folder_is_one_that_nobody_else_writes(mode: int, private: bool, tmp_path: Path) -> None:
    local, own = tmp_path / "__pycache__", tmp_path / "cache"
    local.mkdir()
    local.chmod(mode)
    assert is_private(local) is private
    assert first_usable([local, own], "compiled loops") == (local if private else own)
    assert private or own.stat().st_mode & 0o777 == 0o700


def test_a_folder_that_cannot_be_used_gives_a_notice_and_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever is root can write everywhere, so a file stands where the folder should be."""
    wall, open_to_all = tmp_path / "file", tmp_path / "open"
    wall.write_text("")
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    told: list[str] = []
    monkeypatch.setattr(Notices, "tell", told.append)
    monkeypatch.setattr(Notices, "_given", set())
    folder = first_usable([wall / "a", wall, open_to_all], "compiled loops")
    assert folder.is_dir()
    assert first_usable([wall / "a", wall, open_to_all], "compiled loops") not in (wall, open_to_all)
    assert len(told) == 1
    assert "compiled again" in told[0]
    assert str(wall) in told[0]
    assert f"{open_to_all}: others can write it" in told[0]


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
@pytest.mark.parametrize(("backend", "code"), [("cpu", 5), ("opencl", 5)])
def test_a_forked_child_is_refused_and_spawn_is_named(backend: str, code: int) -> None:
    if backend == "opencl":
        from tests.kits import opencl  # noqa: F401 - skips where there is none
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORK, backend],
        env=env, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.stdout.split() == [str(code)], done.stderr


def test_a_loop_is_out_of_date_with_any_file_that_it_imports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {"loop": "from tactile.middle import (\n    f,\n)\n", "middle": "from tactile import constants\n",
             "constants": "N = 1\n", "other": "N = 1\n"}  # fmt: skip
    (tmp_path / "tactile").mkdir()
    monkeypatch.setattr(compiled_loops, "_ROOT", tmp_path)

    def stamp() -> str:
        compiled_loops._read.cache_clear()
        return compiled_loops._stamp.__wrapped__(tmp_path / "tactile" / "loop.py")

    for name, text in files.items():
        (tmp_path / "tactile" / f"{name}.py").write_text(text)
    before = stamp()
    for name in files:
        (tmp_path / "tactile" / f"{name}.py").write_text(files[name] + "# changed\n")
        assert (stamp() == before) is (name == "other")
        (tmp_path / "tactile" / f"{name}.py").write_text(files[name])


def test_no_loop_is_kept_by_numba_itself() -> None:
    """Its own stamp leaves out what a loop takes from other files."""
    sources = [path for package in ("cnnsim", "tactile") for path in (ROOT / package).rglob("*.py")]
    assert not [path.name for path in sources if "cache=True" in path.read_text(encoding="utf-8")]
