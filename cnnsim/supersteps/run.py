"""Loop over supersteps: all blocks take some steps, then the record is replaced.

States alternate between two arrays, so no task reads what another one writes.
"""

import math
from dataclasses import asdict, dataclass
from pathlib import Path

from cnnsim.backends.base import Check
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_plan import block_plan, halo_of
from cnnsim.supersteps.block_task import STATE, BlockReport, BlockTask, Place, run_block, worst
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import Engine, steps_of_superstep
from cnnsim.supersteps.store import GridStore, zarr_library
from cnnsim.support.progress import watcher
from cnnsim.workers import Workers

STATES = ("x0", "x1")
"""The arrays of the states: superstep n reads x(n mod 2) and writes the other one."""


@dataclass
class Record:
    """The progress in a store: the ``side`` of its blocks, the supersteps and steps done, and the end of the run."""

    side: int
    superstep: int = 0
    step: int = 0
    ended: bool = False
    settled: bool = False
    saturated: bool = False
    rate: float = math.nan


class Supersteps:
    """A transient of a large grid that continues from its ``record``.

    ``planes`` are the Zarr arrays of the initial state, input, bias and mask, by name. The states are arrays of the
    ``store``.
    """

    def __init__(
        self, plan: Plan, store: GridStore, record: Record, planes: dict[str, Path], place: Place, engine: Engine,
        workers: Workers,
    ) -> None:  # fmt: skip
        self.plan, self.record, self.devices = plan, record, set[str]()
        self._store, self._planes, self._place, self._workers = store, planes, place, workers
        self._blocks = Blocks(plan.shape, record.side, plan.boundary)
        self._settling = plan.duration == "settled" and plan.method != "closed form"
        self._depth = 1 if plan.method == "closed form" else steps_of_superstep(engine, plan, record.side)

    @property
    def state(self) -> Path:
        """The array with the current states."""
        name = STATES[self.record.superstep % 2]
        return self._store.folder / name if self.record.superstep else self._planes[STATE]

    def run(self) -> None:
        """Run supersteps until the network has settled or the duration is reached."""
        record, plan = self.record, self.plan
        if not record.superstep:
            shape = zarr_library().open_array(self.state, mode="r").shape
            for name in STATES:
                if self._store.folder / name != self.state:
                    self._store.create(name, shape, self._place.dtype, record.side)
        while not record.ended:
            after = record.step + 1 if plan.method == "closed form" else min(record.step + self._depth, plan.steps)
            checks = self._checks(after)
            reports = self._tasks(after - record.step, checks)
            found = [worst([report.checks[number] for report in reports]) for number in range(len(checks))]
            last = next((n for n, check in enumerate(found) if check.settled or check.repeats), None)
            if last is not None and checks[last] < after:
                after = checks[last]
                self._tasks(after - record.step, ())
            self._commit(after, None if last is None else found[last], found[-1] if found else None)

    def _checks(self, after: int) -> tuple[int, ...]:
        """Return the steps of a superstep after which the blocks check whether the network has settled."""
        if not self._settling:
            return ()
        first, plan = self.record.step + (self.record.superstep > 0), self.plan
        return tuple(step for step in range(first, after + 1) if step % plan.check_every == 0 or step == plan.steps)

    def _tasks(self, steps: int, checks: tuple[int, ...]) -> list[BlockReport]:
        """Step all blocks, the largest first; return their reports."""
        halo, reports = halo_of(self.plan, steps), list[BlockReport]()
        tasks = [self._task(block, steps, checks, halo) for block in range(len(self._blocks))]
        tasks.sort(key=lambda task: math.prod(task.plan.shape), reverse=True)
        for report in self._workers.map(run_block, tasks):
            reports.append(report)
            self._report(steps * len(reports) / len(tasks))
        self.devices |= {report.device for report in reports} - {""}
        return reports

    def _task(self, block: int, steps: int, checks: tuple[int, ...], halo: int) -> BlockTask:
        rows, cols, _ = self._blocks.around(block, halo)
        target = self._store.folder / STATES[(self.record.superstep + 1) % 2]
        return BlockTask(
            self._blocks, self._place, block_plan(self.plan, rows, cols), block, halo, self.record.step, steps, checks,
            self._planes | {STATE: self.state}, target,
        )  # fmt: skip

    def _report(self, steps: float) -> None:
        if (report := watcher()) is not None:
            step, plan = self.record.step + steps, self.plan
            share = min(1.0, step / max(plan.steps, 1)) if plan.duration != "settled" else None
            report(share, f"t = {step * plan.step:.4g}, {len(self._blocks)} blocks")

    def _commit(self, step: int, end: Check | None, last: Check | None) -> None:
        """Replace the record: a superstep is done, which ended with the check ``end`` if the network has settled."""
        record, plan = self.record, self.plan
        record.superstep, record.step = record.superstep + 1, step
        if plan.method == "closed form":
            record.ended, record.settled = True, plan.duration == "settled"
            record.rate = 0.0 if record.settled else math.nan
        elif end is not None or step >= plan.steps:
            found = end or last or Check(math.nan)
            record.ended, record.settled = True, found.settled
            record.saturated, record.rate = found.saturated, found.rate
        self._store.commit(asdict(record))

    @property
    def time(self) -> float:
        """The time at which the run ended [time constants]."""
        if self.plan.method == "closed form":
            return math.inf if self.plan.duration == "settled" else float(self.plan.duration)
        return self.record.step * self.plan.step if self._settling else float(self.plan.duration)
