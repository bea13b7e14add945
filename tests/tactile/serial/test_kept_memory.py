"""Memory that is kept: arrays of the size of a tare's cost no new pages."""

import platform
import subprocess

import pytest

from tests.kits.processes import code_line

FAULTS = """
import resource
import numpy as np
from tactile.serial.kept_memory import keep_memory

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(200):
        np.ones(40_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

import ctypes
ctypes.CDLL(None).mallopt(-3, 128 * 1024)  # as it is before the first large block was given back
before, agreed = faults(), keep_memory()
np.ones(40_000)
print(before, agreed, faults())
"""


def test_arrays_cost_no_new_pages() -> None:
    if platform.libc_ver()[0] != "glibc":
        pytest.skip("a matter of the GNU C library")
    done = subprocess.run(code_line(FAULTS), capture_output=True, text=True, check=True, timeout=60)
    before, agreed, after = done.stdout.split()
    assert agreed == "True"
    if int(before) == 0:
        pytest.skip("this kernel counts no page faults")
    assert int(after) < int(before) / 10
