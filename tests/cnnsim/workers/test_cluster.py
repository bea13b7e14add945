"""A lost connection is the end of the scheduler, noticed by the client or not; an OSError is the task's own."""

from collections.abc import Callable
from typing import Any

import pytest

from cnnsim.workers.cluster import ClusterWorkers, LostSchedulerError


class Failed:
    """A future that ended with an error."""

    def __init__(self, key: str, error: Exception) -> None:
        self.key, self._error = key, error

    def add_done_callback(self, told: Callable[[Any], None]) -> None:
        told(self)

    def result(self) -> None:
        raise self._error

    def release(self) -> None: ...


class Client:
    """A client that takes its scheduler for alive."""

    status = "running"

    def __init__(self, error: Exception) -> None:
        self._error, self._count = error, 0

    def nthreads(self) -> dict[str, int]:
        return {"worker": 1}

    def submit(self, function: Callable[[int], int], task: int, *, pure: bool) -> Failed:
        self._count += 1
        return Failed(str(self._count), self._error)


def test_a_lost_connection_is_the_scheduler_s_end() -> None:
    comm = pytest.importorskip("distributed.comm")
    workers = ClusterWorkers(
        Client(comm.CommClosedError("ConnectionResetError: Connection reset by peer")), "tcp://a:1"
    )
    with pytest.raises(LostSchedulerError, match="the scheduler tcp://a:1 has gone"):
        list(workers.map(abs, [1, 2, 3]))


def test_what_a_task_met_is_told_as_it_is() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(OSError, match="No space left"):
        list(ClusterWorkers(Client(OSError(28, "No space left")), "tcp://a:1").map(abs, [1, 2, 3]))
