"""Job of a sweep: a handful of cases run in one launch by a worker process, failures found case by case."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from time import perf_counter
from typing import Any, NamedTuple

from cnnsim.sweep.kind import Kind, Row, kernel_seconds
from cnnsim.sweep.table import NUMBER
from cnnsim.workers.base import one_thread


class Launch(NamedTuple):
    """Cases of one group by number, which are run together."""

    group: Any
    cases: Sequence[tuple[int, Mapping[str, Any]]]


class Job(NamedTuple):
    """Launches that one worker does, and the module of their kind."""

    module: str
    launches: Sequence[Launch]

    @property
    def size(self) -> int:
        """How many cases there are."""
        return sum(len(launch.cases) for launch in self.launches)

    def halves(self) -> "list[Job]":
        """Return the job in two, by launches, or one launch by its cases."""
        parts: Sequence[Any] = self.launches if len(self.launches) > 1 else self.launches[0].cases
        both = parts[: len(parts) // 2], parts[len(parts) // 2 :]
        if len(self.launches) > 1:
            return [self._replace(launches=part) for part in both]
        return [self._replace(launches=[self.launches[0]._replace(cases=part)]) for part in both]


class Done(NamedTuple):
    """Rows of a job, one a case; the seconds of each launch; and those of all in kernels."""

    job: Job
    rows: list[Row]
    seconds: list[float]
    kernels: float


def run_job(job: Job) -> Done:
    """Run a job on one thread: the sweep has as many workers as there are cores."""
    with one_thread():
        return _run(job)


def died(job: Job) -> Done:
    """Return what came of a job whose process died."""
    rows = [
        row
        for launch in job.launches
        for row in _named(launch, [{"error": "its process died"}] * len(launch.cases), 0.0)
    ]
    return Done(job, rows, [0.0] * len(job.launches), 0.0)


def _run(job: Job) -> Done:
    kind: Kind = import_module(job.module).KIND
    before, rows, seconds = kernel_seconds(), list[Row](), list[float]()
    for launch in job.launches:
        begun = perf_counter()
        found = _rows(kind, [case for _, case in launch.cases])
        seconds.append(perf_counter() - begun)
        rows += _named(launch, found, seconds[-1])
    return Done(job, rows, seconds, kernel_seconds() - before)


def _named(launch: Launch, rows: Sequence[Row], seconds: float) -> list[Row]:
    each = seconds / len(launch.cases)
    return [
        {NUMBER: number, **case, **row, "seconds": each} for (number, case), row in zip(launch.cases, rows, strict=True)
    ]


def _rows(kind: Kind, cases: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Return a row for each case; where one of several fails, halves are run until it stands alone."""
    try:
        return [{**row, "error": None} for row in kind.run(cases)]
    except Exception as error:  # whatever a case does, the others go on: it becomes a row with its error
        if len(cases) == 1:
            return [{"error": " ".join(f"{type(error).__name__}: {error}".split())}]
        half = len(cases) // 2
        return [*_rows(kind, cases[:half]), *_rows(kind, cases[half:])]
