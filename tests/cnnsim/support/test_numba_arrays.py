"""Numba's array functions: there without scipy.linalg, which is found when a loop wants it."""

import subprocess
import sys

TEXT = """
import sys
import numba, numpy
from cnnsim.support.compiling import kept_loops

assert "numba.np.arraymath" in sys.modules and "scipy.linalg" not in sys.modules
a = numpy.arange(4.0)
assert numba.njit(lambda a, b: numpy.dot(a, b))(a, a) == 14
assert sys.modules["scipy.linalg.cython_blas"].__spec__.origin
"""
ASKED = """
from cnnsim.support.compiling import numba_arrays as arrays

standing = arrays.sys.modules[arrays._BLAS] = arrays._Standing(arrays._BLAS)
assert "dgemm" in standing.__pyx_capi__ and arrays.sys.modules[arrays._BLAS] is not standing
"""


def test_linear_algebra_is_imported_by_the_first_loop_that_calls_it() -> None:
    subprocess.run([sys.executable, "-c", TEXT], check=True)


def test_who_asks_meanwhile_gets_the_module() -> None:
    subprocess.run([sys.executable, "-c", ASKED], check=True)
