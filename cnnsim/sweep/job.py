"""Job of a sweep: a handful of cases run in one launch by a worker process, failures found case by case."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from time import perf_counter
from typing import Any, NamedTuple

from cnnsim.sweep.kind import Kind, Row, kernel_seconds
from cnnsim.sweep.table import NUMBER
from cnnsim.workers.base import one_thread


class Job(NamedTuple):
    """Cases by number, and the module of their kind."""

    module: str
    cases: Sequence[tuple[int, Mapping[str, Any]]]
    group: Any

    def halves(self) -> "list[Job]":
        """Return the job in two halves; one of a single case stays whole."""
        half = len(self.cases) // 2
        return [self._replace(cases=part) for part in (self.cases[:half], self.cases[half:]) if part]


class Done(NamedTuple):
    """Rows of a job, one a case, and its seconds: all of them, and those in kernels."""

    job: Job
    rows: list[Row]
    seconds: float
    kernels: float


def run_job(job: Job) -> Done:
    """Run a job on one thread: the sweep has as many workers as there are cores."""
    with one_thread():
        return _run(job)


def died(job: Job) -> Done:
    """Return what came of a job whose process died."""
    return Done(job, _named(job, [{"error": "its process died"}] * len(job.cases), 0.0), 0.0, 0.0)


def _run(job: Job) -> Done:
    kind: Kind = import_module(job.module).KIND
    begun, in_kernels = perf_counter(), kernel_seconds()
    rows = _rows(kind, [case for _, case in job.cases])
    seconds = perf_counter() - begun
    return Done(job, _named(job, rows, seconds), seconds, kernel_seconds() - in_kernels)


def _named(job: Job, rows: Sequence[Row], seconds: float) -> list[Row]:
    return [
        {NUMBER: number, **case, **row, "seconds": seconds / len(rows)}
        for (number, case), row in zip(job.cases, rows, strict=True)
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
