"""Workers as processes of this machine: joblib's, which are started afresh when one of them was killed."""

import signal
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from cnnsim.support import InputError
from cnnsim.support.extras import install_line
from cnnsim.support.interrupts import held_back
from cnnsim.support.memory import free_memory
from cnnsim.workers.base import Lost, Workers

KEPT = 0.25
"""Of the free memory, what a process may have grown by before it is taken to leak: planes of blocks are kept."""
Task = TypeVar("Task")
Outcome = TypeVar("Outcome")


class LocalWorkers(Workers):
    """``count`` processes; a single worker is this process."""

    def __init__(self, count: int) -> None:
        self.count = count
        try:
            import joblib  # type: ignore[import-untyped]  # it ships no types
        except ImportError as error:
            raise InputError(f"worker processes are joblib's, which is missing: {install_line('scale')}") from error
        self._joblib = joblib

    def map(self, function: Callable[[Task], Outcome], tasks: Iterable[Task]) -> Iterator[Outcome | Lost]:
        """See `Workers.map`."""
        if self.count == 1:
            yield from map(function, tasks)
            return
        waiting, drawn = iter(tasks), dict[int, Task]()
        numbered = self._numbered(waiting, drawn)
        while True:
            try:
                for number, outcome in self._run(function, numbered):
                    del drawn[number]
                    yield outcome
            except self._died():
                for number, task in list(drawn.items()):  # those that were under way, one by one: which was it?
                    yield self._alone(function, task)
                    del drawn[number]
                numbered = self._numbered(waiting, drawn)
                continue
            return

    def _alone(self, function: Callable[[Task], Outcome], task: Task) -> Outcome | Lost:
        try:
            return next(self._run(function, [(0, task)]))[1]
        except self._died():
            return Lost(task)

    @staticmethod
    def _numbered(tasks: Iterator[Task], drawn: dict[int, Task]) -> Iterator[tuple[int, Task]]:
        for task in tasks:
            number = max(drawn, default=-1) + 1
            drawn[number] = task  # before it is handed out: what was drawn and not handed back is run again
            yield number, task

    def _run(self, function: Callable[[Task], Outcome], tasks: Iterable[tuple[int, Task]]) -> Iterator[Any]:
        parallel = self._joblib.Parallel(
            n_jobs=self.count, return_as="generator_unordered", batch_size=1, pre_dispatch=2 * self.count,
            max_nbytes=None,
        )  # fmt: skip
        outcomes: Any = None
        try:
            with _unheard_by_children():
                outcomes = parallel(self._joblib.delayed(_with_number)(function, *task) for task in tasks)
            yield from outcomes
        except BaseException:
            if outcomes is not None:
                with _in_silence():
                    outcomes.close()
            raise

    @staticmethod
    def _died() -> type[Exception]:
        from joblib.externals.loky.process_executor import (  # type: ignore[import-untyped]  # the same
            TerminatedWorkerError,  # joblib has it under no other name
        )

        return TerminatedWorkerError


@contextmanager
def _in_silence() -> Iterator[None]:
    """Keep off stderr what joblib says of tasks that are given up, and what its own thread then misses."""
    before, threading.excepthook = threading.excepthook, lambda _: None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        threading.excepthook = before


@contextmanager
def _unheard_by_children() -> Iterator[None]:
    """Hold Ctrl-C back in a block in which processes start, which inherit that it is blocked.

    A terminal sends it to all of them, and each would end in a traceback of its own; who started them ends them.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # as it starts it unblocks the signal, whether it was blocked or not
    with held_back():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _with_number(function: Callable[[Task], Outcome], number: int, task: Task) -> tuple[int, Outcome]:
    _keep_memory()
    return number, function(task)


@cache
def _keep_memory() -> None:
    """Let this process keep what it has for its next task: joblib takes 300 MB for a leak, and starts it afresh."""
    from joblib.externals.loky import process_executor  # type: ignore[import-untyped]  # the same

    process_executor._MAX_MEMORY_LEAK_SIZE = KEPT * free_memory()
