"""Workers of a Dask cluster: one of this machine that is made for the run, or one whose scheduler has an address."""

import logging
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

from cnnsim.support import InputError
from cnnsim.support.extras import install_line
from cnnsim.workers.base import Lost, Workers, cores

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")
AHEAD = 2
"""Tasks a worker has: one that it runs, one that it need not wait for."""
PATIENCE = 15.0
"""Seconds in which a scheduler answers, or a first worker is there."""

SILENCE = 5.0
"""Seconds without a scheduler after which it has gone."""


class LostSchedulerError(InputError):
    """The scheduler of a cluster has gone."""


class ClusterWorkers(Workers):
    """The workers of a client's cluster, each with as many tasks at a time as it has threads."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self.count = sum(client.nthreads().values())

    def map(self, function: Callable[[Task], Outcome], tasks: Iterable[Task]) -> Iterator[Outcome | Lost]:
        """See `Workers.map`.

        Raises:
            LostSchedulerError: the scheduler has gone.
        """
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        waiting, under_way, ended = iter(tasks), dict[str, tuple[Any, Task]](), SimpleQueue[Any]()

        def submit() -> None:
            for task in waiting:
                future = self._client.submit(function, task, pure=False)
                under_way[future.key] = future, task
                future.add_done_callback(ended.put)
                return

        try:
            for _ in range(AHEAD * max(self.count, 1)):
                submit()
            while under_way:
                future = self._next(ended)
                _, task = under_way.pop(future.key)
                try:
                    yield future.result()
                except KilledWorker:
                    yield Lost(task)
                submit()
        except (OSError, CancelledError) as error:
            if self._client.status == "running" and not isinstance(error, CancelledError | CommClosedError):
                raise  # what the task itself met: a full disk; a lost connection the client may yet take for alive
            raise self._gone() from error
        finally:
            for future, _ in under_way.values():
                future.release()

    def _next(self, ended: "SimpleQueue[Any]") -> Any:
        """Return the next future that ended; of a scheduler that has gone none ever will."""
        quiet = 0.0
        while True:
            try:
                return ended.get(timeout=1.0)
            except Empty:
                quiet = quiet + 1.0 if self._client.status != "running" else 0.0
                if quiet > SILENCE:
                    raise self._gone() from None

    def _gone(self) -> LostSchedulerError:
        return LostSchedulerError(f"the scheduler {self._address} has gone")


@contextmanager
def cluster_workers(address: str, count: int | None) -> Iterator[Workers]:
    """Give the workers of the cluster at ``address``, or of one that is made here, reached from this machine alone.

    Raises:
        InputError: dask is missing; nobody answers; a cluster without workers.
    """
    try:
        import distributed
    except ImportError as error:
        raise InputError(f"clusters are Dask's, which is missing: {install_line('scale')}") from error
    with _quiet(), _client(distributed, address, count) as workers:
        yield workers


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the tracebacks of lost connections off stderr: what is lost is told as an error of our own."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "tornado", "asyncio")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _client(distributed: Any, address: str, count: int | None) -> Iterator[Workers]:
    if not address:
        number = count or cores()
        with (
            distributed.LocalCluster(
                n_workers=number, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
                silence_logs="CRITICAL", memory_limit=0,
            ) as cluster,
            distributed.Client(cluster) as client,
        ):  # fmt: skip
            yield ClusterWorkers(client, "of this machine")
        return
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(f"no scheduler answers at {address}: {error}") from error
    with client:
        try:
            client.wait_for_workers(count or 1, timeout=PATIENCE)
        except TimeoutError as error:
            raise InputError(f"the scheduler {address} has fewer than {count or 1} workers; start some") from error
        yield ClusterWorkers(client, address)
