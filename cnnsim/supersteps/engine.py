"""Engine: where a large grid's blocks are computed, and how it is cut; its choices where none are made."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from cnnsim.backends.memory import cell_bytes
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.depth import first_depth
from cnnsim.support import InputError
from cnnsim.support.memory import check_memory, free_memory
from cnnsim.support.values import is_whole
from cnnsim.workers.engine import check_engine_name

LARGEST, SMALLEST = 4096, 64
"""Sides of blocks: the most, and the least. Planes of larger ones cost more when the system hands them out than their
halo saves."""
SLEEPING, ACROSS, FEWEST = 512, 32, 8
"""Sides where blocks may sleep: a front keeps those awake that it crosses, of ``ACROSS`` each way a few. Below
``SLEEPING`` cells a task costs more than its block sleeps, but with fewer than ``FEWEST`` each way hardly one does."""
SLEEPERS = 4
"""Blocks for each worker at least where some of them may sleep."""
WHOLE = 256
"""Sides above it are multiples of it, so that the chunks of a shard have that many rows."""
DISK, TASK, UNEVEN = 16, 1.4e7, 0.1
"""What a block takes besides its steps: to read and write a cell as long as so many steps of it, a task as long as so
many steps of cells; and the part of a block by which workers are apart at the end of a superstep."""
WORKER_BYTES = 250e6
"""Memory of a worker process before it has a block: Python, NumPy and compiled loops."""
SHARE = 0.5
"""Of the free memory, what the workers may take: the system keeps what they write in the rest."""


@dataclass(frozen=True)
class Engine:
    """Where blocks are computed: ``name`` is "processes", "dask", or "dask=ADDRESS" of a scheduler.

    ``store``: the folder of the run's arrays, which a run that was stopped goes on from; None for a passing one.
    ``workers``: processes, None for one a core; ``side`` of a block [cells] and ``depth``, the steps of a superstep,
    None for what fits and what is measured to be fastest.
    """

    name: str = "processes"
    store: Path | None = None
    workers: int | None = None
    side: int | None = None
    depth: int | None = None

    def __post_init__(self) -> None:
        check_engine_name(self.name)
        for what in ("side", "depth", "workers"):
            value = getattr(self, what)
            if value is not None and not (is_whole(value) and value >= 1):
                raise InputError(f"{what} {value!r} of an engine; a whole number above 0 wanted")

    def side_of_store(self, folder: Path, side: int) -> int:
        """Return the side of the blocks in a store that is gone on with, whatever the workers are.

        Raises:
            InputError: the engine wants another one.
        """
        if self.side not in (None, side):
            raise InputError(f"{folder} has blocks of {side} cells, not of {self.side}; {side}, or none said, wanted")
        return side


def parse_engine(engine: "str | Engine", store: "str | Path | None") -> Engine:
    """Return an engine by its name, with a store where one is given."""
    found = Engine(engine) if isinstance(engine, str) else engine
    return found if store is None else replace(found, store=Path(store))


def side_of_blocks(engine: Engine, shape: tuple[int, ...], workers: int, *, sleeps: bool) -> int:
    """Return the side of a block: the engine's own, or that with the shortest superstep of those that fit."""
    if engine.side is not None:
        return engine.side
    rows, cols = shape[-2:]
    fits = math.isqrt(int(SHARE * free_memory() / workers / 64)) if math.isfinite(free_memory()) else LARGEST
    most = max(SMALLEST, min(_of_sleepers(rows * cols, workers) if sleeps else LARGEST, fits))
    most, longest = most // WHOLE * WHOLE if most >= WHOLE else most, max(rows, cols)
    parts = range(-(-longest // most), max(-(-longest // most), longest // SMALLEST) + 1)
    sides = {min(most, _whole(-(-longest // part))) for part in parts}

    def seconds(side: int) -> float:
        """Return how long a step of the grid takes, in steps of a cell."""
        blocks, depth = math.ceil(rows / side) * math.ceil(cols / side), first_depth(side, 1, sleeps=sleeps)
        return (math.ceil(blocks / workers) + UNEVEN) * ((side + depth) ** 2 + (DISK * side**2 + TASK) / depth)

    return min(sides, key=seconds)


def _of_sleepers(cells: int, workers: int) -> int:
    """Return the side of blocks of which most may sleep, and which serve all workers."""
    across = math.isqrt(cells)
    few = min(across // FEWEST, math.isqrt(cells // (SLEEPERS * workers)))
    return min(LARGEST, max(across // ACROSS, min(SLEEPING, few)))


def _whole(side: int) -> int:
    """Return a side for blocks that are to have so many rows at least."""
    return max(SMALLEST, side if side < WHOLE else -(-side // WHOLE) * WHOLE)


def worker_bytes(
    plan: Plan, side: int, halo: int, lead: int, itemsize: int, given: int, *, has_mask: bool, backend: str
) -> float:
    """Return the memory of a worker [bytes]: itself, a block with its halo read, and what the backend makes of it."""
    cells = lead * (min(side, plan.shape[0]) + 2 * halo) * (min(side, plan.shape[1]) + 2 * halo)
    each = cell_bytes(plan, 1 + given, itemsize, has_mask=has_mask, backend=backend)
    each += (2 + given) * itemsize  # as read, and as given
    return WORKER_BYTES + cells * each


def check_workers_memory(needed: float, workers: int, side: int) -> None:
    """Refuse blocks that are too large for all workers together.

    Raises:
        InputError: what they need, what is free, and the cure.
    """
    check_memory(f"{workers} workers with blocks of {side} x {side} cells", workers * needed, "smaller blocks wanted")
