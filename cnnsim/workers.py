"""Worker processes that run tasks: a process pool of this machine, or the workers of a Dask cluster."""

import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ProcessPoolExecutor, as_completed
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from multiprocessing import active_children, get_context, parent_process, resource_tracker
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from cnnsim.support import InputError
from cnnsim.support.extras import install_line

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")
ATTEMPTS = 3
"""How often tasks run whose worker process dies."""
TIMEOUT = 15.0
"""Seconds in which a Dask scheduler has to answer, and its first worker has to be there."""


class WorkerDiedError(InputError):
    """A worker process died in each of `ATTEMPTS` attempts; ``unfinished`` are the tasks without an outcome."""

    def __init__(self, unfinished: Sequence[Any]) -> None:
        super().__init__(
            f"a worker process died {ATTEMPTS} times; fewer workers, smaller blocks or more memory wanted, and in a "
            "script the line if __name__ == '__main__':"
        )
        self.unfinished = unfinished


class Workers:
    """``count`` workers; ``open_executor`` opens the executor that runs tasks on them, None for this process."""

    def __init__(self, count: int, open_executor: Callable[[], AbstractContextManager[Executor]] | None) -> None:
        self.count, self._open_executor = count, open_executor

    def map(self, function: Callable[[Task], Outcome], tasks: Sequence[Task]) -> Iterator[Outcome]:
        """Yield the outcome of each task, in the order in which they finish.

        A task runs again if its process dies, so it has to give the same outcome each time.

        Raises:
            WorkerDiedError: a worker process died in each of `ATTEMPTS` attempts.
        """
        if self._open_executor is None:
            yield from map(function, tasks)
            return
        left = dict(enumerate(tasks))
        for _ in range(ATTEMPTS):
            try:
                with self._open_executor() as executor:
                    futures = {executor.submit(function, task): number for number, task in left.items()}
                    for future in as_completed(futures):
                        outcome = future.result()
                        del left[futures[future]]
                        yield outcome
            except BrokenExecutor:
                continue
            return
        raise WorkerDiedError(list(left.values()))


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


_COMPUTING = threading.Lock()


@contextmanager
def one_thread() -> Iterator[None]:
    """Compute on one thread in a block; only one thread of a worker computes at a time."""
    import numba  # slow to import

    with _COMPUTING:
        before = numba.get_num_threads()
        numba.set_num_threads(1)
        try:
            yield
        finally:
            numba.set_num_threads(before)


def check_engine_name(name: str) -> None:
    """Check the name of an engine: "processes", or "dask=ADDRESS" with the address of a scheduler.

    Raises:
        InputError: another name, or no address.
    """
    if name in ("dask", "dask="):
        raise InputError(f"engine {name!r} without an address; dask=tcp://HOST:PORT of a running scheduler wanted")
    if name != "processes" and not name.startswith("dask="):
        raise InputError(f"engine {name!r}; processes or dask=ADDRESS wanted")


@contextmanager
def open_workers(name: str, count: int | None = None) -> Iterator[Workers]:
    """Open the workers of an engine: ``count`` processes (default: one a core), or all workers of a cluster.

    Raises:
        InputError: an unknown engine, a missing library, a scheduler that does not answer or is lost.
    """
    check_engine_name(name)
    if count is not None and count < 1:
        raise InputError(f"{count} workers; 1 or more wanted")
    if name == "processes":
        number = count or cores()
        yield Workers(number, None if number == 1 else lambda: _process_pool(number))
        return
    with _cluster(name.removeprefix("dask="), count) as workers:
        yield workers


_IDLE: dict[int, tuple[ProcessPoolExecutor, list[BaseProcess]]] = {}
"""Pools with their processes by their number: they stay for the next run, as they take a second to start."""


@contextmanager
def _process_pool(count: int) -> Iterator[Executor]:
    """Open a pool of ``count`` processes; after an error its processes are terminated."""
    pool, processes = _IDLE.pop(count) if count in _IDLE else _started(count)
    try:
        yield pool
    except BaseException:
        for process in processes:
            process.terminate()
        pool.shutdown(cancel_futures=True)
        raise
    _IDLE[count] = pool, processes


def _started(count: int) -> tuple[ProcessPoolExecutor, list[BaseProcess]]:
    """Start a pool whose processes ignore Ctrl-C: a terminal sends it to all processes, and this one ends the others.

    Processes inherit that the signal is blocked; the resource tracker would unblock it, so it starts before.
    """
    resource_tracker.ensure_running()
    before, known = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}), set(active_children())
    try:
        pool = ProcessPoolExecutor(count, get_context("spawn"), _end_with_parent)
        for _ in range(count):  # each of the first tasks starts a process
            pool.submit(int)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return pool, [process for process in active_children() if process not in known]


def _end_with_parent() -> None:
    """End this worker process when its parent process ends, even if that is killed."""

    def wait() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


@contextmanager
def _cluster(address: str, count: int | None) -> Iterator[Workers]:
    try:
        distributed: Any = import_module("distributed")  # slow to import
    except ImportError as error:
        raise InputError(f"dask.distributed is missing: {install_line('scale')}") from error
    with _silent("distributed", "distributed.client", "tornado", "tornado.application", "asyncio"):
        try:
            client = distributed.Client(address, timeout=TIMEOUT)
        except (OSError, ValueError, TypeError, RuntimeError) as error:  # TLS without certificates: a TypeError
            raise InputError(f"no scheduler answers at {address}: {error}") from error
        with client:
            try:
                client.wait_for_workers(count or 1, timeout=TIMEOUT)
            except TimeoutError as error:
                raise InputError(f"the scheduler {address} has fewer than {count or 1} workers; start some") from error
            yield Workers(sum(client.nthreads().values()), lambda: _cluster_executor(client, address))


@contextmanager
def _cluster_executor(client: Any, address: str) -> Iterator[Executor]:
    """Open the executor of a Dask client.

    Raises:
        InputError: the connection to the scheduler is lost.
    """
    from distributed.comm.core import CommClosedError

    executor = client.get_executor()
    try:
        yield executor
    except (OSError, CancelledError) as error:
        if client.status == "running" and not isinstance(error, CancelledError | CommClosedError):
            raise  # an error of a task, such as a full disk
        raise InputError(f"the scheduler {address} is lost") from error
    finally:
        executor.shutdown(wait=False)


@contextmanager
def _silent(*names: str) -> Iterator[None]:
    """Silence loggers in a block: lost connections are reported as one error instead of their tracebacks."""
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    for logger in levels:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)
