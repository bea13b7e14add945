"""Kept loops after a change in another file: made anew where it is compiled in, kept where it is not."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cnnsim.support.fingerprint import fingerprint
from tests.kits.paths import ROOT

CALLER = """
from cnnsim.support.compiled_loops import kept_njit
import callee
from callee import inlined, linked, nested, COUNT, WHAT

@kept_njit(error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})
def sum_of(x):
    return inlined(x) + linked(x) + nested(x) + COUNT + WHAT[1] + callee.other(x)

if __name__ == "__main__":
    print(sum_of(1.0), sum(sum_of.stats.cache_hits.values()))
"""
CALLEE = """
import numpy as np
from numba import njit
from cnnsim.support.compiled_loops import kept_njit

COUNT = 10
WHAT = np.array([1.0, 100.0])

@njit(inline="always")
def inlined(x):
    return 2 * x

@kept_njit(error_model="numpy")
def linked(x):
    return 3 * x

@kept_njit()
def deep(x):
    return 5 * x

@kept_njit()
def nested(x):
    return deep(x)

@njit
def other(x):
    return 7 * x

def apart(x):
    return 11 * x
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2 * x", "4 * x"),
        ("3 * x", "4 * x"),
        ("5 * x", "6 * x"),
        ("7 * x", "8 * x"),
        ("COUNT = 10", "COUNT = 20"),
        ("100.0", "200.0"),
        ("@kept_njit(error_model", "@kept_njit(fastmath=True, error_model"),
    ],
)
def test_what_is_compiled_in_counts_and_nothing_beside_it(
    old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "caller.py").write_text(CALLER)

    def of(callee: str) -> str:
        (tmp_path / "callee.py").write_text(callee)
        for name in ("caller", "callee"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        return fingerprint(importlib.import_module("caller").sum_of.py_func)

    before = of(CALLEE)
    assert of(CALLEE.replace("11 * x", "12 * x").replace("def apart", "# a word\n\ndef apart")) == before
    assert of(CALLEE.replace(old, new)) != before


def test_a_kept_loop_follows_a_change_in_another_file(tmp_path: Path) -> None:
    """The order of a set of options is another one in each process: that is no change."""
    (tmp_path / "caller.py").write_text(CALLER)
    env = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "loops")}

    def answer(callee: str, seed: int) -> str:
        env["PYTHONHASHSEED"] = str(seed)
        (tmp_path / "callee.py").write_text(callee)
        command = [sys.executable, "-B", str(tmp_path / "caller.py")]
        done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert answer(CALLEE, 1) == "127.0 0"
    assert answer(CALLEE, 2) == "127.0 1"
    assert answer(CALLEE.replace("5 * x", "6 * x"), 3) == "128.0 0"


def test_no_loop_is_kept_by_numba_itself() -> None:
    """Its own files on disk are neither checked nor follow what is compiled in."""
    sources = [path for package in ("cnnsim", "tactile") for path in (ROOT / package).rglob("*.py")]
    assert len(sources) > 600
    assert not [path.name for path in sources if "cache=True" in path.read_text(encoding="utf-8")]
