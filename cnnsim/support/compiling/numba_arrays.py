"""Numba's array functions, imported without scipy.linalg: it takes 0.2 s, and no loop here calls it.

Numba only asks whether `scipy.linalg.cython_blas` can be imported, before its first loop. What `np.dot` and others call
there is looked up when they are compiled, and found then: nothing is left in its place.
"""

import sys
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any

_BLAS = "scipy.linalg.cython_blas"


class _Standing(ModuleType):
    """A module that is imported once somebody asks for anything in it: another thread may, at this moment."""

    def __getattr__(self, name: str) -> Any:
        _clear(self)
        return getattr(import_module(self.__name__), name)


def _clear(standing: ModuleType) -> None:
    if sys.modules.get(_BLAS) is standing:
        del sys.modules[_BLAS]


def import_array_functions() -> None:
    """Import what numba has for arrays."""
    if "numba.np.arraymath" in sys.modules or _BLAS in sys.modules or find_spec("scipy") is None:
        return
    standing = sys.modules[_BLAS] = _Standing(_BLAS)
    try:
        import_module("numba.np.arraymath")
    finally:
        _clear(standing)
