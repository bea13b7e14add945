"""Compiled loops: numba with its disk cache in a folder that no other user can write.

Numba compiles a cached function again when its own file has changed, but not when a function or a constant that it
takes from another file has. Here the cache is stamped with the contents of all files of this package that the file of
a loop imports, directly or not.
"""

import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from inspect import getfile
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import config, sigutils
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.ccallback import CFunc

from cnnsim.support.cache_folder import first_usable, user_cache
from cnnsim.support.errors import InputError
from cnnsim.support.interrupts import listen_to_numba

listen_to_numba()
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
"""Threads that spin while they wait take the cores of others; OpenMP reads this when the first loop starts them."""

_ROOT = Path(__file__).parents[2]
_IMPORT = re.compile(r"^from ((?:cnnsim|tactile)[.\w]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_OUTSIDE = "cnnsim.support"
"""Modules of which nothing is compiled into loops."""


@cache
def folder() -> Path:
    """Return the cache folder: NUMBA_CACHE_DIR, or one next to the code, or the user's, or a temporary one."""
    own = (Path(config.CACHE_DIR),) if config.CACHE_DIR else ()
    local = Path(__file__).with_name("__pycache__")
    return first_usable((*own, local, user_cache() / "cellular-wave-touch" / "loops"), "loops")


@cache
def _stamp(file: Path) -> str:
    """Return a digest of a file, of all files of this package that it imports, and of NumPy's version."""
    found, waiting = {file}, [file]
    while waiting:
        new = _read(waiting.pop())[1] - found
        found |= new
        waiting += new
    return sha256("".join([np.__version__, *sorted(_read(each)[0] for each in found)]).encode()).hexdigest()


@cache
def _read(file: Path) -> tuple[str, frozenset[Path]]:
    """Return the digest of a file and the files that it imports."""
    text = file.read_text(encoding="utf-8")
    named = [(module, re.findall(r"\w+", names)) for module, names in _IMPORT.findall(text)]
    modules = (m for module, names in named if not module.startswith(_OUTSIDE)
               for m in (module, *(f"{module}.{name}" for name in names)))  # fmt: skip
    paths = (_ROOT.joinpath(*module.split(".")) for module in modules)
    files = (each for path in paths for each in (path.with_suffix(".py"), path / "__init__.py"))
    return sha256(text.encode()).hexdigest(), frozenset(each for each in files if each.is_file())


class _Locator:
    """Gives numba the folder of a loop's cache, and a checksum of the source that the loop was compiled from."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._file = Path(getfile(function))
        how = [(key, sorted(value) if isinstance(value, set) else value) for key, value in sorted(options.items())]
        digest = sha256(f"{self._file} {how}".encode()).hexdigest()[:8]  # numba's keys have neither
        self._name = f"{function.__code__.co_firstlineno}-{digest}"

    def from_function(self, _function: Any, _file: str) -> "_Locator":
        return self

    def ensure_cache_path(self) -> None:
        folder().mkdir(mode=0o700, parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        return str(folder())

    def get_source_stamp(self) -> str:
        return _stamp(self._file)

    def get_disambiguator(self) -> str:
        return self._name


class _Loops(CompileResultCacheImpl):  # type: ignore[misc]  # numba says nothing of its types
    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._locator_classes = [_Locator(function, options)]
        super().__init__(function)


class _Cache(FunctionCache):  # type: ignore[misc]  # the same
    """Numba's cache of one function; with a damaged file the function is compiled again; a full disk is ignored."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._impl_class = lambda function: _Loops(function, options)
        super().__init__(function)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a damaged pickle can raise any exception
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(OSError):
            super().save_overload(sig, data)


class _Threaded:
    """A loop on several threads, refused in a forked process: the threads are those of its parent."""

    forked = False

    def __init__(self, jitted: Any) -> None:
        self._jitted = jitted

    def __call__(self, *given: Any) -> Any:
        if _Threaded.forked:
            raise InputError("threaded loops in a forked process; multiprocessing with the method 'spawn' wanted")
        return self._jitted(*given)


def _after_fork() -> None:
    with suppress(ValueError):  # no threads have been started
        numba.threading_layer()
        _Threaded.forked = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def kept_njit(**options: Any) -> Callable[[Any], Any]:
    """Compile like `numba.njit` with these options, cached on disk."""

    def wrapped(function: Any) -> Any:
        jitted = numba.njit(**options)(function)
        jitted._cache = _Cache(function, options)
        return _Threaded(jitted) if options.get("parallel") else jitted

    return wrapped


def kept_helper(**options: Any) -> Callable[[Any], Any]:
    """Compile like `kept_njit` a function that only compiled functions call: it compiles sooner."""
    return kept_njit(**options, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def kept_cfunc(signature: Any, **options: Any) -> Callable[[Any], Any]:
    """Compile like `numba.cfunc` with these options, cached on disk."""

    def wrapped(function: Any) -> Any:
        compiled: Any = CFunc(function, sigutils.normalize_signature(signature), locals={}, options=options)
        compiled._cache = _Cache(function, {"at": str(signature), **options})
        compiled.compile()
        return compiled

    return wrapped
