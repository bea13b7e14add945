"""Block task: read a block with its halo, step it on a backend, check whether it has settled, write the block."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cnnsim import backends
from cnnsim.backends.base import Backend, Check, check_area
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.blocks import Area, Blocks, read_cells
from cnnsim.supersteps.store import zarr_library
from cnnsim.support import Array
from cnnsim.support.errors import naming
from cnnsim.workers import one_thread

STATE, INPUT, BIAS, MASK = "state", "input", "bias", "mask"


class Place(NamedTuple):
    """The backend that computes: its name, dtype and device."""

    backend: str
    dtype: str
    device: str | None = None


@dataclass(frozen=True)
class BlockTask:
    """Steps of one block; it does not write what it reads, so it can run again at any time.

    Arguments: ``plan`` of the block with its halo; ``first`` step and number of ``steps``; ``checks``: the steps at
    which it is checked whether the block has settled; ``planes``: the Zarr arrays by name; ``target``: the Zarr array
    to write to.
    """

    blocks: Blocks
    place: Place
    plan: Plan
    block: int
    halo: int
    first: int
    steps: int
    checks: tuple[int, ...]
    planes: dict[str, Path]
    target: Path


@dataclass(frozen=True)
class BlockReport:
    """Result of a task: its checks in order, and the OpenCL device."""

    checks: Sequence[Check]
    device: str


@cache
def backend_of(place: Place) -> tuple[Backend, str]:
    """Return the backend of this process and the title of its OpenCL device: one of its own if none is chosen."""
    if place.backend != "opencl":
        return backends.get(place.backend, place.dtype, place.device, 1 if place.backend == "cpu" else None), ""
    from cnnsim.backends.opencl.device.devices import own_device, title_of  # needs pyopencl

    own = own_device() if place.device is None else place.device
    found = backends.get(place.backend, place.dtype, None if own is None else str(own))
    return found, title_of(found)


def run_block(task: BlockTask) -> BlockReport:
    """Run a task."""
    zarr = zarr_library()
    rows, cols, ((r0, r1), (c0, c1)) = task.blocks.around(task.block, task.halo)
    planes = {name: read_cells(zarr.open_array(path, mode="r"), rows, cols) for name, path in task.planes.items()}
    place = f"block {task.block}, from row {rows[r0]}, column {cols[c0]}"
    with one_thread(), naming(place):
        where, device = backend_of(task.place)
        after, checks = _BlockSteps(where, task.plan, planes, ((r0, r1), (c0, c1))).run(task)
    inner = after[..., r0:r1, c0:c1]
    (p0, p1), (q0, q1) = task.blocks.area(task.block)
    with zarr.config.set({"array.write_empty_chunks": True}):  # without a comparison
        target = zarr.open_array(task.target, mode="r+")
    target[..., p0:p1, q0:q1] = inner
    return BlockReport(checks, device)


class _BlockSteps:
    """The time steps of a block with its halo on a backend; ``inside`` is the area of the block."""

    def __init__(self, where: Backend, plan: Plan, planes: dict[str, Array], inside: Area) -> None:
        self._where, self._plan, self._inside = where, plan, inside
        self._x = where.load(planes[STATE], "lam", copy=False)
        self._u, self._bias, self._mask = (
            where.load(planes[name], "llm" if name == MASK else "lam", copy=False) if name in planes else None
            for name in (INPUT, BIAS, MASK)
        )
        self._plans: dict[int, Plan] = {}

    def run(self, task: BlockTask) -> tuple[Array, list[Check]]:
        """Step from check to check; return the states with the halo, and the checks."""
        x, step, before, checks = self._x, task.first, None, list[Check]()
        discrete = task.plan.cell == "discrete-time"
        for until in sorted({*task.checks, task.first + task.steps}):
            if discrete and task.checks:  # a check compares the state with those of the steps before and after
                for _ in range(until - step):
                    before, x = x, self._stepped(x, 1)
            else:
                x = self._stepped(x, until - step)
            step = until
            if step in task.checks:
                checks.append(self._compared(before, x) if discrete else self._checked(x))
        return self._where.read(x, copy=False), checks

    def _stepped(self, x: Any, steps: int) -> Any:
        if not steps:
            return x
        if self._plan.method == "closed form":
            return self._where.transient(self._plan, x, self._u, self._bias, self._mask).x
        if steps not in self._plans:
            plan = self._plan  # without sleep, which keeps the outputs, but not the states, of saturated cells
            self._plans[steps] = replace(plan, duration=steps * plan.step, savings=plan.savings - {"sleep"})
        return self._where.transient(self._plans[steps], x, self._u, self._bias, self._mask).x

    def _checked(self, x: Any) -> Check:
        return check_area(self._where, self._plan, (x, self._u, self._bias, self._mask), self._inside)

    def _compared(self, before: Any, x: Any) -> Check:
        """Check a discrete-time state: the largest change in the next step, and whether that leads to ``before``."""
        (r0, r1), (c0, c1) = self._inside
        old, now, after = (
            None if plane is None else self._where.read(plane)[..., r0:r1, c0:c1]
            for plane in (before, x, self._stepped(x, 1))
        )
        assert now is not None and after is not None
        change = float(np.abs(after - now).max())
        return Check(change, repeats=old is not None and np.array_equal(after, old))


def worst(checks: Sequence[Check]) -> Check:
    """Return the check of a grid from the checks of its blocks."""
    return Check(
        max((check.rate for check in checks), default=math.nan),
        all(check.saturated for check in checks),
        all(check.repeats for check in checks),
    )
