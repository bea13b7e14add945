"""Number of threads of the CPU backend: checked, and set while a function runs."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numba

from cnnsim.support import InputError
from cnnsim.support.values import is_whole

_VERBS = "load", "read", "convert", "output", "transient", "cellwise", "logic", "neighbourhood", "count"


def checked_threads(threads: Any) -> int:
    """Return ``threads`` if it is a whole number from 1 to the number of cores.

    Raises:
        InputError: another value.
    """
    most = int(numba.config.NUMBA_NUM_THREADS)
    if not is_whole(threads) or not 1 <= threads <= most:
        raise InputError(f"threads {threads!r}; a whole number from 1 to {most}, the number of cores, wanted")
    return int(threads)


def on_threads(function: Callable[..., Any], threads: int) -> Callable[..., Any]:
    """Return a function that runs on ``threads`` threads; numba's setting for the process is restored after it."""

    @wraps(function)
    def run(*args: Any, **kwargs: Any) -> Any:
        before = numba.get_num_threads()
        numba.set_num_threads(threads)
        try:
            return function(*args, **kwargs)
        finally:
            numba.set_num_threads(before)

    return run


def keep_to(backend: Any, threads: int) -> None:
    """Make all methods of a backend run on ``threads`` threads."""
    for verb in _VERBS:
        setattr(backend, verb, on_threads(getattr(backend, verb), threads))
