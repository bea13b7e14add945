"""Runs a sweep on worker processes or on a Dask cluster, and goes on with one that was stopped."""

from collections import defaultdict, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from threading import Thread
from time import perf_counter
from typing import Any

from cnnsim.support.progress import watcher
from cnnsim.sweep.job import Done, Job, Launch, died, run_job
from cnnsim.sweep.kind import Row
from cnnsim.sweep.spec import Sweep
from cnnsim.sweep.table import SweepTable
from cnnsim.workers import Lost, Workers, open_workers

JOB_SECONDS, SHORTEST, PARTS = 1.0, 0.1, 4
"""How long a job is to take, as to hand one out costs some milliseconds; how long the last ones are to, and the part of
what is left, for each worker, that they are cut into."""
PART_SECONDS = 5.0
"""How often rows are written: what a crash may cost."""
FIRST, MOST = 4, 4096
"""Cases in the first launch of a group, when nobody knows how long one takes, and the most: more gain nothing."""


@dataclass(frozen=True)
class SweepSummary:
    """How a sweep went: all its rows, how many failed, how many were run now, and the share of the cores in kernels."""

    rows: list[Row]
    failed: int
    run: int
    seconds: float
    busy: float
    file: Path


class _Pace:
    """Cuts what is left into jobs whose size follows the seconds that cases of their group took."""

    def __init__(self, sweep: Sweep, left: Sequence[int], workers: int) -> None:
        self._sweep, self._each = sweep, dict[Any, float]()
        self._left, self._workers = len(left), workers
        self._waiting: dict[Any, deque[int]] = defaultdict(deque)
        group = sweep.kind.group
        for number in left:
            self._waiting[None if group is None else group(sweep.case(number))].append(number)

    def learn(self, done: Done) -> None:
        """Take how long launches took; compiling makes the first ones slow, so the least counts."""
        for launch, seconds in zip(done.job.launches, done.seconds, strict=True):
            each = seconds / len(launch.cases)
            self._each[launch.group] = min(each, self._each.get(launch.group, each))

    def jobs(self) -> Iterator[Job]:
        """Yield jobs until no case is left; each is as long as what has been learnt by then says.

        A group that nobody knows yet is taken for as slow as half of the known ones: the first of them were slow, as
        their workers loaded what is compiled.
        """
        while self._waiting:
            launches, left = list[Launch](), self._seconds()
            while self._waiting and left > 0:
                group = next(iter(self._waiting))
                numbers = self._waiting.pop(group)
                each = self._each.get(group, median(self._each.values() or [JOB_SECONDS / FIRST]))
                most = max(1, min(MOST, int(left / max(each, 1e-6))))
                now = [numbers.popleft() for _ in range(min(most, len(numbers)))]
                self._left -= len(now)
                if numbers:
                    self._waiting[group] = numbers  # at the end: other groups have their turn
                launches.append(Launch(group, [(number, self._sweep.case(number)) for number in now]))
                left -= max(each, 1e-6) * len(now)
                if left < each:
                    break
            yield Job(self._sweep.module, launches)

    def _seconds(self) -> float:
        """Return how long the next job is to take: towards the end less, so that all workers end together."""
        rest = self._left * sum(self._each.values()) / max(len(self._each), 1)
        return min(JOB_SECONDS, max(SHORTEST, rest / (PARTS * self._workers))) if self._each else JOB_SECONDS


def run_sweep(sweep: Sweep, folder: Path, *, engine: str = "processes", workers: int | None = None) -> SweepSummary:
    """Run the cases that have no row in ``folder`` yet, and return all rows, of earlier runs too.

    Arguments: ``engine`` and ``workers`` as `cnnsim.workers.open_workers` takes them.

    Raises:
        InputError: a folder of another sweep; an unknown engine; a missing library; no scheduler, or one that has gone.
    """
    table, begun = SweepTable(folder, sweep.digest), perf_counter()
    have = table.done()
    left = [number for number in range(len(sweep)) if number not in have]
    seconds = busy = 0.0
    if left:
        with open_workers(engine, workers) as crew:
            Thread(target=table.prepare).start()  # while the processes start
            busy = _run(sweep, left, table, crew)
            seconds = perf_counter() - begun
            busy /= seconds * crew.count
    rows = table.finish()
    failed = sum(row.get("error") is not None for row in rows)
    return SweepSummary(rows, failed, len(left), seconds, busy, table.file)


def _run(sweep: Sweep, left: Sequence[int], table: SweepTable, workers: Workers) -> float:
    """Run cases, write their rows now and then, and return the seconds in kernels."""
    pace, rows, written, kernels, count = _Pace(sweep, left, workers.count), list[Row](), perf_counter(), 0.0, 0
    try:
        for done in _survivors(pace, workers):
            pace.learn(done)
            rows, kernels, count = rows + done.rows, kernels + done.kernels, count + len(done.rows)
            if perf_counter() - written > PART_SECONDS:
                table.add(rows)
                rows, written = [], perf_counter()
            if (told := watcher()) is not None:
                told(count / len(left), f"{count} of {len(left)} cases")
    finally:
        table.add(rows)
    return kernels


def _survivors(pace: _Pace, workers: Workers) -> Iterator[Done]:
    """Yield what came of all jobs; where a process died on one, its halves are run, down to the case that did it."""
    fatal = list[Job]()
    for done in workers.map(run_job, pace.jobs()):
        if isinstance(done, Lost):
            fatal.append(done.task)
        else:
            yield done
    while fatal:
        job = fatal.pop()
        if job.size == 1:
            yield died(job)
            continue
        for half in job.halves():
            for done in workers.map(run_job, [half]):
                if isinstance(done, Lost):
                    fatal.append(half)
                else:
                    yield done
