"""Run a sweep on worker processes or a Dask cluster, and resume a stopped one from its table."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from cnnsim.support.progress import watcher
from cnnsim.sweep.kind import Kind, Row
from cnnsim.sweep.spec import Sweep
from cnnsim.sweep.table import NUMBER, SweepTable
from cnnsim.workers import WorkerDiedError, Workers, one_thread, open_workers

MOST, PARTS = 64, 4
"""Cases of a job: the most, and the jobs a group is divided into for each worker."""


@dataclass(frozen=True)
class SweepSummary:
    """All rows of a sweep, how many cases failed, how many ran now, and the seconds they took."""

    rows: list[Row]
    failed: int
    run: int
    seconds: float
    file: Path


class SweepJob(NamedTuple):
    """Cases of one group by number, and the module of their kind."""

    module: str
    cases: Sequence[tuple[int, Mapping[str, Any]]]


def run_sweep(sweep: Sweep, folder: Path, *, engine: str = "processes", workers: int | None = None) -> SweepSummary:
    """Run the cases that have no row in the table in ``folder``, and return all rows.

    Arguments: ``engine`` and ``workers`` as in `cnnsim.workers.open_workers`.

    Raises:
        InputError: a folder of another sweep; an unknown engine; a missing library; a scheduler that does not answer.
    """
    table, begun = SweepTable(folder, sweep.digest), perf_counter()
    left = [number for number in range(len(sweep)) if number not in table.rows]
    if left:
        with open_workers(engine, workers) as crew:
            jobs = _jobs(sweep, left, crew.count)
            try:
                for rows in _rows_of_jobs(jobs, crew):
                    table.add(rows)
                    if (report := watcher()) is not None:
                        report(len(table.rows) / len(sweep), f"{len(table.rows)} of {len(sweep)} cases")
            finally:
                table.write()
    rows = table.sorted_rows()
    failed = sum(row.get("error") is not None for row in rows)
    return SweepSummary(rows, failed, len(left), perf_counter() - begun if left else 0.0, table.file)


def _jobs(sweep: Sweep, left: Sequence[int], workers: int) -> list[SweepJob]:
    """Divide cases into jobs by their groups; without groups a job has one case."""
    group, groups = sweep.kind.group, defaultdict[Any, list[int]](list)
    for number in left:
        groups[number if group is None else group(sweep.case(number))].append(number)
    jobs = []
    for numbers in groups.values():
        size = min(MOST, -(-len(numbers) // (PARTS * workers)))
        for first in range(0, len(numbers), size):
            cases = [(number, sweep.case(number)) for number in numbers[first : first + size]]
            jobs.append(SweepJob(sweep.module, cases))
    return jobs


def _rows_of_jobs(jobs: Sequence[SweepJob], workers: Workers) -> Iterator[list[Row]]:
    """Yield the rows of all jobs; after a worker died, run the unfinished cases one by one to find the fatal one."""
    try:
        yield from workers.map(run_job, jobs)
    except WorkerDiedError as error:
        for job in error.unfinished:
            for number, case in job.cases:
                try:
                    yield from workers.map(run_job, [SweepJob(job.module, [(number, case)])])
                except WorkerDiedError:
                    yield [{NUMBER: number, **case, "error": "its process died"}]


def run_job(job: SweepJob) -> list[Row]:
    """Run a job on one thread and return its rows."""
    kind: Kind = import_module(job.module).KIND
    begun = perf_counter()
    with one_thread():
        rows = _rows(kind, [case for _, case in job.cases])
    each = (perf_counter() - begun) / len(rows)
    return [
        {NUMBER: number, **case, **row, "seconds": each} for (number, case), row in zip(job.cases, rows, strict=True)
    ]


def _rows(kind: Kind, cases: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Return a row for each case; if one of several fails, the cases are run one by one."""
    try:
        return [{**row, "error": None} for row in kind.run(cases)]
    except Exception as error:  # a case that fails becomes a row with its error
        if len(cases) == 1:
            return [{"error": " ".join(f"{type(error).__name__}: {error}".split())}]
        return [row for case in cases for row in _rows(kind, [case])]
