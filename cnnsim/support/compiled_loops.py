"""Compiled loops kept on disk: numba's compilers with a cache that is private, checked, and never in the way.

A file of the cache is a pickle with machine code, so it is code: one that somebody else could have written is not read.
Each begins with the digest of the rest, so that a damaged one is noticed; it is deleted and made anew.
"""

import os
import pickle
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from hashlib import sha256
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import numpy as np
from numba.core import config, sigutils
from numba.core.caching import FunctionCache
from numba.core.ccallback import CFunc
from numba.core.serialize import dumps

from cnnsim.support.cache_folder import first_usable, is_private, user_cache
from cnnsim.support.fingerprint import fingerprint, stable
from cnnsim.support.interrupts import listen_to_numba

_BYTES = sha256().digest_size
_BLAS = "scipy.linalg.cython_blas"


def _load_without_blas() -> None:
    """Load numba's arrays, as the first loop would, without scipy.linalg, which takes a quarter of a second.

    Numba imports it there only to see that it is there, as it is wherever this package is installed. So an empty module
    has its name meanwhile; a loop that multiplies matrices imports the real one when it is compiled.
    """
    if _BLAS not in sys.modules and "numba.np.arraymath" not in sys.modules:
        sys.modules[_BLAS] = ModuleType(_BLAS)
        try:
            import_module("numba.np.arraymath")
        finally:
            del sys.modules[_BLAS]


_load_without_blas()
listen_to_numba()


def _candidates() -> list[Path]:
    own = (Path(config.CACHE_DIR),) if config.CACHE_DIR else ()
    beside = Path(__file__).with_name("__pycache__")
    return [*own, beside, user_cache() / "cellular-wave-touch" / "loops"]


@cache
def folder() -> Path:
    """Return the folder of the disk cache: NUMBA_CACHE_DIR, or beside the code, or the user's, or a temporary one."""
    return first_usable(_candidates(), "compiled loops that are not kept yet")


@cache
def _read_from() -> tuple[Path, ...]:
    """Return where kept loops are looked for: the folder, and those before it that cannot be written, or not now.

    On a full disk all that was compiled before is still there.
    """
    full = takewhile(lambda candidate: candidate != folder(), _candidates())
    return folder(), *(path for path in full if path.is_dir() and is_private(path))


class LoopFiles:
    """The files of one function, one for each signature and processor: all that numba asks of them."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        code = function.__code__
        name = f"{function.__module__}.{function.__qualname__}.{code.co_firstlineno}".replace("<locals>.", "")
        how = f"{code.co_filename} {sorted(options.items(), key=str)}"  # numba's keys say nothing of either
        self._stem = f"{name}.{sha256(how.encode()).hexdigest()[:8]}"
        self._function = function

    @cached_property
    def _known(self) -> tuple[str, ...]:
        return numba.__version__, np.__version__, fingerprint(self._function)

    def load(self, key: Any) -> Any:
        """Return what is kept under a key, None where there is nothing that can be trusted."""
        return next((data for place in _read_from() if (data := self._load(key, self._path(key, place)))), None)

    def _load(self, key: Any, path: Path) -> Any:
        try:
            raw = path.read_bytes()
        except OSError:
            return None
        with suppress(Exception):  # whatever a pickle of other versions may raise
            if is_private(path) and sha256(raw[_BYTES:]).digest() == raw[:_BYTES]:
                known, of, data = pickle.loads(raw[_BYTES:])
                if (known, of) == (self._known, key):
                    return data
        with suppress(OSError):
            path.unlink()
        return None

    def save(self, key: Any, data: Any) -> None:
        """Keep data under a key; a full disk keeps nothing."""
        raw = dumps((self._known, key, data))
        with suppress(OSError):
            handle, name = tempfile.mkstemp(dir=folder())
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(sha256(raw).digest() + raw)
                Path(name).replace(self._path(key, folder()))
            except OSError:
                Path(name).unlink()

    def flush(self) -> None:
        """Forget all."""
        for path in folder().glob(f"{self._stem}.*.loop"):
            path.unlink()

    def _path(self, key: Any, place: Path) -> Path:
        return place / f"{self._stem}.{sha256(str(key).encode()).hexdigest()[:16]}.loop"


def _keep(compiler: Any, function: Any, options: dict[str, Any]) -> None:
    """Give a function's compiler its files; numba's own are not read nor written."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder())  # numba refuses a cache where it finds no folder of its own
    try:
        compiler.enable_caching()
    finally:
        config.CACHE_DIR = before
    kept: FunctionCache = compiler._cache
    kept._cache_file = LoopFiles(function, options)
    kept._cache_path = str(folder())


class Threaded:
    """A loop on several threads; after a fork on one: the threads of the parent are not in the child.

    GNU OpenMP ends a child that uses it, others wait for ever for the threads.
    """

    after_fork = False

    def __init__(self, jitted: Any, function: Any, options: dict[str, Any]) -> None:
        self.jitted, self._function, self._options = jitted, function, options
        self._alone: Any = None

    def __call__(self, *given: Any) -> Any:
        """Run the loop."""
        if not Threaded.after_fork:
            return self.jitted(*given)
        if self._alone is None:
            self._alone = kept_njit(**{**self._options, "parallel": False})(self._function)
        return self._alone(*given)


def _forked() -> None:
    with suppress(ValueError):  # no threads had been started
        numba.threading_layer()
        Threaded.after_fork = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def kept_njit(**options: Any) -> Callable[[Any], Any]:
    """Compile like `numba.njit` with these options, with the cache of this module; see `Threaded`."""

    def wrapped(function: Any) -> Any:
        jitted = numba.njit(**options)(function)
        _keep(jitted, function, {key: stable(value) for key, value in options.items()})
        return Threaded(jitted, function, options) if options.get("parallel") else jitted

    return wrapped


def kept_helper(**options: Any) -> Callable[[Any], Any]:
    """Compile like `kept_njit` what only compiled functions call: without the code for calls from Python, sooner."""
    return kept_njit(**options, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def kept_cfunc(signature: Any, **options: Any) -> Callable[[Any], Any]:
    """Compile like `numba.cfunc` with these options, with the cache of this module."""

    def wrapped(function: Any) -> Any:
        compiled = CFunc(function, sigutils.normalize_signature(signature), locals={}, options=options)
        _keep(compiled, function, {"at": str(signature), **options})
        compiled.compile()
        return compiled

    return wrapped
