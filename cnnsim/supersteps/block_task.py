"""Block task: a block of the grid with a halo is read, stepped on a backend, checked, and written as one shard."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from cnnsim import backends
from cnnsim.backends.base import BlockBackend, Check
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_plan import reach_of
from cnnsim.supersteps.block_planes import read_planes
from cnnsim.supersteps.blocks import Area, Blocks
from cnnsim.supersteps.store import INPUT, GridStore
from cnnsim.support import Array, InputError
from cnnsim.support.errors import naming
from cnnsim.workers.base import one_thread

EVERY, FEW = 16, 0.02
"""One row of so many is looked at, and up to this share of its cells may move, before a block is checked in full."""
STRIP = 64
"""Rows that are looked at for what is not finite at a time: they stay in the cache."""


class Place(NamedTuple):
    """Which backend computes: its name, dtype and device."""

    backend: str
    dtype: str
    device: str | None = None


@dataclass(frozen=True)
class BlockTask:
    """Steps of one block; it reads what nobody writes meanwhile, so it can be run again at any time.

    Arguments: ``plan`` of the block with its halo; ``first`` step, and how many ``steps``; ``checks``: steps after
    which it is checked whether the block has settled; ``behind``: steps that it slept through and takes instead;
    ``planes``: the arrays with the states of the blocks that it reads; ``target``: the array that it writes to, None
    for a check alone.
    """

    folder: Path
    blocks: Blocks
    place: Place
    plan: Plan
    block: int
    halo: int
    first: int
    steps: int
    planes: dict[int, str]
    target: str | None
    given: tuple[str, ...]
    checks: tuple[int, ...] = ()
    behind: int = 0
    run: str = ""


@dataclass(frozen=True)
class BlockReport:
    """What a task found: its checks, in order, the seconds of reading and writing and of stepping, and the device."""

    block: int
    checks: Sequence[Check] = field(default_factory=tuple)
    disk: float = 0.0
    stepping: float = 0.0
    device: str = ""


@cache
def backend_of(place: Place) -> tuple[BlockBackend, str]:
    """Return the backend of this process, and on OpenCL what its device is called: its own, if none was asked for."""
    if place.backend != "opencl":
        return backends.get(place.backend, place.dtype, place.device, 1 if place.backend == "cpu" else None), ""
    from cnnsim.backends.opencl.device.devices import own_device, title_of  # only there is pyopencl wanted

    own = own_device() if place.device is None else place.device
    found = backends.get(place.backend, place.dtype, None if own is None else str(own))
    return found, title_of(found)


@lru_cache(4)
def _store(folder: Path, blocks: Blocks, _run: str) -> GridStore:
    return GridStore(folder, blocks)


def run_block(task: BlockTask) -> BlockReport:
    """Run a task."""
    store, begun = _store(task.folder, task.blocks, task.run), perf_counter()
    rows, cols, inside = task.blocks.around(task.block, task.halo)
    dtype = np.dtype(task.place.dtype)
    x, given = read_planes(store, task.planes, task.given, (rows, cols), dtype)
    read = perf_counter()
    (r0, r1), (c0, c1) = inside
    with one_thread(), naming(f"block {task.block}, from row {rows[r0]}, column {cols[c0]}"):
        if task.first == 0:  # what stays where it was is read here for the first time
            _check_finite(given if given.get(INPUT) is x else {"state": x, **given})
        where, device = backend_of(task.place)
        steps = _BlockSteps(where, task, x, given, inside)
        after, checks = steps.caught_up() if task.behind else steps.run()
    stepped = perf_counter()
    if task.target is not None:
        store.write(task.target, task.blocks.area(task.block), after[..., r0:r1, c0:c1])
        if not np.may_share_memory(after, x):
            where.take_back(after)
    return BlockReport(task.block, checks, read - begun + perf_counter() - stepped, stepped - read, device)


def _check_finite(planes: dict[str, Array]) -> None:
    for name, plane in planes.items():
        for row in range(0, plane.shape[-2], STRIP) if plane.dtype != bool else ():
            if not np.isfinite(plane[..., row : row + STRIP, :]).all():
                raise InputError(f"{name} holds what is not finite")


class _BlockSteps:
    """The planes of a block with its halo on a backend."""

    def __init__(self, where: BlockBackend, task: BlockTask, x: Array, given: dict[str, Array], inside: Area) -> None:
        self._where, self._task, self._plan, self._x, self._inside = where, task, task.plan, x, inside
        u, bias, mask = (given.get(name) for name in (INPUT, "bias", "mask"))
        self._planes = (
            None if u is None else where.load(u, "lam", copy=False),
            None if bias is None else where.load(bias, "lam", copy=False),
            None if mask is None else where.load(mask, "llm"),
        )  # fmt: skip

    def run(self) -> tuple[Array, list[Check]]:
        """Take the steps, from check to check; return the states with the halo, and the checks."""
        where, task, checks = self._where, self._task, list[Check]()
        x, done, before = where.load(self._x, "lam", copy=False), task.first, None
        discrete = self._plan.cell == "discrete-time"
        for step in sorted({*task.checks, task.first + task.steps}):
            if discrete and task.checks:  # a check of discrete time looks at the outputs before and after
                for _ in range(step - done):
                    before, x = x, self._advanced(x, 1)
            elif step > done:
                x = self._advanced(x, step - done, task.first + task.steps - step + bool(task.checks))
            done = step
            if step in task.checks and self._plan.duration == "settled":
                checks.append(self._compared(before, x) if discrete else self._checked(x))
        after = where.read(x, copy=False)
        if task.checks and not checks:  # whether the block may sleep: nobody asks for its rate
            checks.append(Check(math.inf) if self._moves(after) else self._checked(x))
        return after, checks

    def _moves(self, x: Array) -> bool:
        """Return whether many cells of the block are not saturated, by a look at some rows."""
        (r0, r1), (c0, c1) = self._inside
        return float((np.abs(x[..., r0:r1:EVERY, c0:c1]) < 1).mean()) > FEW

    def _advanced(self, x: Any, steps: int, after: int | None = None) -> Any:
        """Take steps, ``after`` which so many more are taken or checked: None where all cells are wanted."""
        if self._plan.method == "closed form":
            return self._where.transient(self._plan, x, *self._planes).x
        if after is not None:
            part = self._within(after * reach_of(self._plan))
            if (end := self._where.advance(self._plan, x, *self._planes, part, steps)) is not None:
                return end
        plan = replace(self._plan, duration=steps * self._plan.step, savings=self._plan.savings - {"sleep"})
        u, bias, mask = self._planes
        return self._where.transient(plan, x, u, bias, mask).x

    def _within(self, margin: int) -> Area:
        """Return the area of the block with so many cells around it, as far as they are there."""
        (rows, cols), (down, across) = self._x.shape[-2:], self._inside
        return (
            (max(down[0] - margin, 0), min(down[1] + margin, rows)),
            (max(across[0] - margin, 0), min(across[1] + margin, cols)),
        )

    def _checked(self, x: Any) -> Check:
        found = self._where.check(self._plan, x, *self._planes, self._inside)
        return found if found.moving is None else found._replace(moving=self._on_grid(found.moving))

    def _on_grid(self, area: Area) -> Area:
        """Return the rows and columns of the grid of an area of the block."""
        (rows, cols), block = area, self._task.blocks.area(self._task.block)
        down, across = (first - inner for (first, _), (inner, _) in zip(block, self._inside, strict=True))
        return (rows[0] + down, rows[1] + down), (cols[0] + across, cols[1] + across)

    def _compared(self, before: Any, x: Any) -> Check:
        (r0, r1), (c0, c1) = self._inside
        planes = [None if p is None else self._where.read(p) for p in (before, x, self._advanced(x, 1))]
        old, now, after = (None if p is None else p[..., r0:r1, c0:c1] for p in planes)
        assert now is not None and after is not None
        repeats = old is not None and np.array_equal(after, old)
        return Check(float(np.abs(after - now).max()), repeats=repeats)

    def caught_up(self) -> tuple[Array, list[Check]]:
        """Take the steps through which the block slept: its outputs, and those around it, stood still meanwhile."""
        where, task, (u, bias, mask) = self._where, self._task, self._planes
        (r0, r1), (c0, c1) = self._inside
        x = where.load(self._x, "lam")
        end = where.catch_up(self._plan, x, u, bias, mask, self._inside, task.behind)
        if end is not None:
            return where.read(end), []
        now, left = self._x.copy(), task.behind
        while left:  # what comes in from outside a halo that is too small is thrown away before it comes in
            count = min(left, task.steps)
            after = where.read(self._advanced(where.load(now, "lam"), count))[..., r0:r1, c0:c1]
            if np.array_equal(after, now[..., r0:r1, c0:c1]):
                break  # no bit changes any more
            now[..., r0:r1, c0:c1] = after
            left -= count
        return now, []
