"""What workers are: processes that take tasks, each computed on one thread."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Lock
from typing import Any, Protocol, TypeVar

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")


@dataclass(frozen=True)
class Lost:
    """In place of an outcome: the process that ran this task died, and so did another that ran nothing else."""

    task: Any


class Workers(Protocol):
    """Processes that take tasks; each computes on one thread."""

    count: int

    def map(self, function: Callable[[Task], Outcome], tasks: Iterable[Task]) -> Iterator[Outcome | Lost]:
        """Yield what the function makes of each task, in any order; tasks are drawn as workers come free.

        A task may be run again where a process died, so it must do the same each time. What it raises is raised here.
        """


_ONE_AT_A_TIME = Lock()


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute on one thread in a block, one block at a time: a worker may have threads of its own for its tasks."""
    import numba  # slow to import, and only wanted in workers

    with _ONE_AT_A_TIME:
        before = numba.get_num_threads()
        numba.set_num_threads(1)
        try:
            yield
        finally:
            numba.set_num_threads(before)


def cores() -> int:
    """Return the cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
