"""The number of threads of the CPU backend: checked, measured, and set while a function runs."""

import time
from collections.abc import Callable
from functools import wraps
from typing import Any

import numba
import numpy as np

from cnnsim.backends.cpu import planes
from cnnsim.support import InputError
from cnnsim.support.values import is_whole

_PLANE, _TRIES, _PATIENCE = (512, 512), 30, 0.02
"""The plane of the loop that is timed, its launches, and seconds for them: some milliseconds on an idle machine."""
_VERBS = ("load", "read", "convert", "output", "transient", "check", "catch_up", "advance", "cellwise", "logic",
          "neighbourhood", "count")  # fmt: skip
"""What a backend does on threads."""


def checked_threads(threads: Any) -> int:
    """Return a number of threads that there can be.

    Raises:
        InputError: another number, or none.
    """
    most = int(numba.config.NUMBA_NUM_THREADS)
    if not is_whole(threads) or not 1 <= threads <= most:
        raise InputError(f"threads {threads!r}; a whole number from 1 to {most}, the cores there are, wanted")
    return int(threads)


def on_threads(function: Callable[..., Any], threads: int) -> Callable[..., Any]:
    """Return a function that runs on so many threads, whatever numba has been told for the rest of the process."""

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
    """Have a backend do all it does on so many threads."""
    for verb in _VERBS:
        setattr(backend, verb, on_threads(getattr(backend, verb), threads))


def threads_that_pay() -> int:
    """Return how many threads are fastest just now: all, or half of them, and so on down to one.

    On a busy machine a launch of a loop lasts until the slowest thread has had its turn, milliseconds instead of
    microseconds, and a transient has hundreds of launches. So a loop over a plane is launched a few times with each
    number of threads, and timed.
    """
    x = np.zeros((1, *_PLANE), np.float32)
    threads = int(numba.get_num_threads())
    spent = _launch(threads, x) if threads > 1 else 0.0
    while threads > 1 and (of_half := _launch(threads // 2, x)) < spent:
        threads, spent = threads // 2, of_half
    return threads


def _launch(threads: int, x: Any) -> float:
    """Return the mean time of a launch [s]; no longer is measured than it takes to see that it is long."""
    loop, y = on_threads(planes.clip.threaded, threads), np.empty_like(x)
    loop(x, y)  # compiled, or loaded, and the threads started
    begin, count = time.perf_counter(), 0
    while count < _TRIES and time.perf_counter() - begin < _PATIENCE:
        loop(x, y)
        count += 1
    return (time.perf_counter() - begin) / count
