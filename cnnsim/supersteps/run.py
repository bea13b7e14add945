"""The superstep loop: blocks that are awake are stepped, checked and written, then the record is replaced.

After each superstep all blocks stand at the same step, but for those that sleep: a block whose cells, and those of all
blocks that can reach it in a superstep, are saturated for good keeps its outputs, so it is not computed. Its states
run towards constant drives, and are taken there when it wakes up (`Backend.catch_up`), to the bit.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

from cnnsim.planning.plan import SETTLED_RATE, Plan
from cnnsim.supersteps.block_plan import block_plan, halo_of, reach_of, wants_small_blocks, with_sleep
from cnnsim.supersteps.block_task import BlockReport, BlockTask, Place, run_block
from cnnsim.supersteps.depth import Depth
from cnnsim.supersteps.progress import tell
from cnnsim.supersteps.store import MASK, STATES, GridStore, Record
from cnnsim.supersteps.tasks import all_done
from cnnsim.workers import Workers

FEW = 8
"""Blocks up to which none is looked at, whether it may sleep, before the first superstep: some cell moves in most."""


@dataclass
class Supersteps:
    """A transient of a large grid: its plan, its store with the record of the last superstep, and its workers.

    ``given`` are the arrays besides the states; ``sleeps``: whether blocks may sleep; ``run`` tells this run from
    others; ``devices``: what the workers have told of their OpenCL devices.
    """

    plan: Plan
    store: GridStore
    record: Record
    place: Place
    workers: Workers
    given: tuple[str, ...]
    depth: int | None
    sleeps: bool
    run: str
    devices: set[str] = field(default_factory=set, init=False)
    _forced: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self.plan = with_sleep(self.plan, sleeps=self.sleeps)

    def to_the_end(self) -> None:
        """Run superstep after superstep until the network has settled, or the time is over."""
        plan, record, settles = self.plan, self.record, self.plan.duration == "settled"
        if plan.method == "closed form":
            self._closed_form()
            return
        every = plan.check_every if settles else None
        small = self.sleeps and wants_small_blocks(plan, self.place.backend, has_mask=MASK in self.given)
        depth = Depth(self.store.blocks.side, reach_of(plan), every, self.depth, sleeps=small)
        several = record.step + depth.steps(plan.steps - record.step) < plan.steps and len(self._all) > FEW
        if (settles or (self.sleeps and several)) and not record.checked:
            reports = self._tasks(self._all, 0, (0,), written=False)
            self._note(reports)
            if settles and self._settled_at(reports, (0,)) == 0:
                self._finish(0)
        while record.end is None and record.step < plan.steps:
            after = record.step + depth.steps(plan.steps - record.step)
            checks = self._checks(after, every)
            awake = self._awake(after - record.step)
            self._catch_up(awake, record.step)
            reports = self._tasks(awake, after - record.step, checks)
            at = self._settled_at(reports, checks) if settles else None
            if at == -1:  # a sleeping block may still be too fast for rest: all are looked at
                self._forced = True
                continue
            if at is not None and at < after:
                reports = self._tasks(awake, at - record.step, (at,))
                after = at
            depth.learn(reports, after - record.step)
            self._commit(reports, after)
            if at is not None:
                self._finish(after)
        if record.end is None:
            self._finish(plan.steps)

    def _closed_form(self) -> None:
        if self.record.end is None:
            self._commit(self._tasks(self._all, 1, ()), 1)
            self._finish(1)

    @property
    def _all(self) -> range:
        return range(len(self.store.blocks))

    def _checks(self, after: int, every: int | None) -> tuple[int, ...]:
        """Return the steps up to the end of a superstep after which blocks are checked."""
        first = self.record.step + 1
        found = {s for s in range(first, after + 1) if s % every == 0 or s == self.plan.steps} if every else set()
        return tuple(sorted(found | ({after} if self.sleeps and after < self.plan.steps else set())))

    def _awake(self, steps: int) -> list[int]:
        """Return the blocks in reach of a cell that is not saturated for good."""
        if not self.sleeps or self._forced:
            return list(self._all)
        record, blocks, halo = self.record, self.store.blocks, steps * reach_of(self.plan)
        found = set[int]()
        for block in self._all:
            if not record.saturated[block]:
                found |= blocks.reached(record.moving[block] or blocks.area(block), halo)
        return sorted(found)

    def _tasks(
        self, blocks: Iterable[int], steps: int, checks: Sequence[int], *, written: bool = True, behind: int = 0
    ) -> list[BlockReport]:
        """Run a task for each block, and again where a worker died."""
        halo = halo_of(self.plan, steps, checked=bool(checks))
        waiting = [self._task(block, steps, tuple(checks), halo, written, behind) for block in blocks]
        waiting.sort(key=lambda task: math.prod(task.plan.shape), reverse=True)  # the last ones are soon over
        told = partial(tell, self, tasks=len(waiting), steps=steps)
        done = all_done(self.workers, run_block, waiting, len(self.store.blocks), told)
        self.devices |= {report.device for report in done}
        return done

    def _task(
        self, block: int, steps: int, checks: tuple[int, ...], halo: int, written: bool, behind: int
    ) -> BlockTask:
        store, record = self.store, self.record
        rows, cols, _ = store.blocks.around(block, halo)
        planes = {near: record.plane[near] for near in store.blocks.touched(rows, cols)}
        target = _other(record.plane[block]) if written else None
        return BlockTask(
            store.folder, store.blocks, self.place, block_plan(self.plan, rows, cols), block, halo, record.step, steps,
            planes, target, self.given, checks, behind, self.run,
        )  # fmt: skip

    def _settled_at(self, reports: Sequence[BlockReport], checks: Sequence[int]) -> int | None:
        """Return the first check at which the transient ends, None if it goes on, -1 if a sleeping block must tell."""
        plan = self.plan
        asleep = set(self._all) - {report.block for report in reports}
        for number, step in enumerate(checks):
            if step % plan.check_every and step != plan.steps:
                continue
            found = [report.checks[number] for report in reports]
            if all(check.saturated for check in found):
                return step
            if all(check.rate <= SETTLED_RATE for check in found):
                if not asleep:
                    return step
                if all(0.5 * self._slowest(block, step) <= SETTLED_RATE for block in asleep):
                    return -1
            if all(check.repeats for check in found):
                return step
        return None

    def _slowest(self, block: int, step: int) -> float:
        """Return the least that the rate of a sleeping block can be: towards a constant drive a step takes off h."""
        return self.record.rate[block] * (1 - self.plan.step) ** (step - self.record.upto[block])

    def _catch_up(self, blocks: Iterable[int], step: int) -> None:
        """Take blocks that slept to this step."""
        by_age: dict[int, list[int]] = {}
        for block in blocks:
            if self.record.upto[block] < step:
                by_age.setdefault(step - self.record.upto[block], []).append(block)
        for behind, several in by_age.items():
            steps = min(behind, self.plan.check_every)
            self._moved(self._tasks(several, steps, (), behind=behind), step)
        if by_age:
            self.store.commit(self.record, self.run)

    def _moved(self, reports: Iterable[BlockReport], step: int) -> None:
        for report in reports:
            self.record.plane[report.block] = _other(self.record.plane[report.block])
            self.record.upto[report.block] = step

    def _note(self, reports: Iterable[BlockReport]) -> None:
        for report in reports:
            if report.checks:
                self.record.saturated[report.block] = bool(report.checks[-1].saturated)
                self.record.rate[report.block] = float(report.checks[-1].rate)
                self.record.moving[report.block] = report.checks[-1].moving
        self.record.checked = True

    def _commit(self, reports: Sequence[BlockReport], step: int) -> None:
        """Replace the record: this superstep is done."""
        self._moved(reports, step)
        self._note(reports)
        self.record.superstep += 1
        self.record.step = step
        self._forced = False
        self.store.commit(self.record, self.run)

    def _finish(self, step: int) -> None:
        """Bring all blocks to the last step and into one array, and note how the run ended."""
        plan, record = self.plan, self.record
        asleep = [block for block in self._all if record.upto[block] < step]
        self._catch_up(asleep, step)
        t, settled, rate = float("inf") if plan.duration == "settled" else float(plan.duration), False, math.nan
        if plan.method == "closed form":
            settled, rate = plan.duration == "settled", 0.0 if plan.duration == "settled" else math.nan
        elif plan.duration == "settled":
            if asleep:
                self._note(self._tasks(asleep, 0, (step,), written=False))
            t, rate = step * plan.step, max(record.rate)
            settled = all(record.saturated) or rate <= SETTLED_RATE
        most = max(STATES, key=record.plane.count)
        others = [block for block in self._all if record.plane[block] != most]
        while others:  # from the input into the first array, and into the second one from there
            self._moved(self._tasks(others, 0, ()), step)
            others = [block for block in others if record.plane[block] != most]
        record.end = {"t": t, "settled": settled, "rate": rate, "plane": most}
        self.store.commit(record, self.run)


def _other(plane: str) -> str:
    """Return the array that a block is written to, whose state is in the other one, or in the input."""
    return STATES[1] if plane == STATES[0] else STATES[0]
