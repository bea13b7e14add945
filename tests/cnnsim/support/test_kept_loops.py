"""Compiled loops on disk: damaged files are made anew, what others can write is not used, forks go on alone."""

import os
import resource
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from cnnsim.support import compiled_loops as kept_loops
from cnnsim.support.cache_folder import first_usable, is_private
from cnnsim.support.compiled_loops import kept_njit
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


def test_a_full_disk_has_what_was_kept_before(cache: Path) -> None:
    """A limit on the size of files stands for it."""
    run(cache)
    place, hits, told = run(cache, full=True)
    assert place != cache
    assert hits == 1
    assert "loops that are not kept yet are made anew" in told


@pytest.mark.parametrize("damage", ["empty", "cut", "garbage", "one bit", "text"])
def test_a_damaged_file_is_noticed_and_made_anew(
    cache: Path, damage: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    cache.mkdir(mode=0o700)
    monkeypatch.setattr(kept_loops, "folder", lambda: cache)
    monkeypatch.setattr(kept_loops, "_read_from", lambda: (cache,))

    def hits() -> int:
        @kept_njit(error_model="numpy")
        def double(x: int) -> int:
            return x + x

        assert double(21) == 42
        return sum(double.stats.cache_hits.values())

    assert hits() == 0
    capfd.readouterr()  # a command line that ran here before may have asked to be told of the first loop
    (file,) = cache.glob("*.loop")
    good = bytearray(file.read_bytes())
    raw = good.copy()
    raw[len(raw) // 2] ^= 1
    cut = bytes(raw[: len(raw) // 3])
    kinds = {"empty": b"", "cut": cut, "garbage": os.urandom(5000), "one bit": bytes(raw), "text": b"no loop"}
    file.write_bytes(kinds[damage])
    assert hits() == 0
    assert hits() == 1
    assert file.read_bytes() != kinds[damage]
    assert capfd.readouterr() == ("", "")


def test_a_folder_that_others_can_write_is_left_in_silence_for_one_of_the_users_own(cache: Path) -> None:
    cache.mkdir()
    cache.chmod(0o777)
    folder, hits, told = run(cache)
    assert folder != cache
    assert not hits
    assert told == ""
    assert not list(cache.glob("*.loop"))


def test_a_file_that_others_can_write_is_not_used(cache: Path) -> None:
    run(cache)
    (file,) = cache.glob("*.loop")
    file.chmod(0o666)
    assert run(cache)[1] == 0


GROUPS = {
    "own": ("ana", 1000, [], True),
    "own, with the owner as a member": ("ana", 1000, ["ana"], True),
    "own, with another member": ("ana", 1000, ["ana", "bert"], False),
    "first of many": ("users", 1000, [], False),
    "another one": ("ana", 1001, [], False),
}


@pytest.mark.parametrize("kind", GROUPS)
def test_a_group_of_one_is_private(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As after a checkout under umask 002, where each user has a group of their own."""
    import grp
    import pwd

    name, first, members, private = GROUPS[kind]
    told: list[str] = []
    monkeypatch.setattr(Notices, "tell", told.append)
    monkeypatch.setattr(Notices, "_told", set())
    monkeypatch.setattr(pwd, "getpwuid", lambda _: SimpleNamespace(pw_name="ana", pw_gid=first))
    monkeypatch.setattr(grp, "getgrgid", lambda _: SimpleNamespace(gr_name=name, gr_mem=members))
    beside, own = tmp_path / "__pycache__", tmp_path / "cache"
    beside.mkdir()
    beside.chmod(0o775)
    found = os.stat_result((0o40775, 1, 1, 2, os.geteuid(), 1000, 4096, 0, 0, 0))
    stat = Path.stat
    monkeypatch.setattr(Path, "stat", lambda path, **options: found if path == beside else stat(path, **options))
    assert is_private(beside) is private
    assert first_usable([beside, own], "compiled loops") == (beside if private else own)
    assert private or stat(own).st_mode & 0o777 == 0o700
    assert not told


def test_the_first_group_of_root_is_not_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import grp
    import pwd

    monkeypatch.setattr(pwd, "getpwuid", lambda _: SimpleNamespace(pw_name="root", pw_gid=0))
    monkeypatch.setattr(grp, "getgrgid", lambda _: SimpleNamespace(gr_name="root", gr_mem=[]))
    found = os.stat_result((0o40775, 1, 1, 2, os.geteuid(), 0, 4096, 0, 0, 0))
    monkeypatch.setattr(Path, "stat", lambda _: found)
    assert not is_private(tmp_path)


def test_a_folder_that_cannot_be_used_is_a_word_and_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever is root can write everywhere, so a file stands where the folder should be."""
    wall, open_to_all = tmp_path / "file", tmp_path / "open"
    wall.write_text("")
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    told: list[str] = []
    monkeypatch.setattr(Notices, "tell", told.append)
    monkeypatch.setattr(Notices, "_told", set())
    folder = first_usable([wall / "a", wall, open_to_all], "compiled loops")
    assert folder.is_dir()
    assert first_usable([wall / "a", wall, open_to_all], "compiled loops") not in (wall, open_to_all)
    assert len(told) == 1
    assert "made anew" in told[0]
    assert str(wall) in told[0]
    assert f"{open_to_all}: others can write it" in told[0]


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


def test_a_first_run_leaves_scipys_matrices_alone_until_a_loop_multiplies_some() -> None:
    code = """
import sys
import numba
import numpy as np
from cnnsim import run
run("edge", np.eye(8) * 2 - 1)
assert "scipy.linalg" not in sys.modules
product = numba.njit(lambda a, b: np.dot(a, b))
square = np.arange(9.0).reshape(3, 3)
assert np.array_equal(product(square, square), square @ square)
print("scipy.linalg.cython_blas" in sys.modules, sys.modules["scipy.linalg.cython_blas"].__file__.endswith("py"))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["True", "False"], done.stderr  # the real one: compiled
