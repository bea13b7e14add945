"""Engine of a large grid: where its blocks are computed, the side of a block, and the steps of a superstep."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cnnsim.backends.memory import cell_bytes
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_plan import halo_of, reach_of
from cnnsim.support import InputError
from cnnsim.support.memory import check_memory, free_memory
from cnnsim.support.values import is_whole
from cnnsim.workers import check_engine_name

LARGEST, SMALLEST = 2048, 64
"""Sides of blocks [cells]: the largest and the least."""
BLOCKS_PER_WORKER = 2
MOST_STEPS = 256
"""The most steps of a superstep; a stopped run loses at most this number."""
HALO_PART = 16
"""The halo of a superstep is at most this part of a block's side."""
WORKER_BYTES = 250e6
"""Memory of a worker process without a block: Python, NumPy and compiled loops."""
MEMORY_SHARE = 0.5
"""Share of the free memory that workers may take; the system caches files in the rest."""


@dataclass(frozen=True)
class Engine:
    """Where blocks are computed: ``name`` is "processes" of this machine, or "dask=ADDRESS" of a Dask scheduler.

    ``store``: the folder of the run's Zarr arrays, from which a stopped run resumes; None for a temporary one.
    ``workers``: number of processes, None for one a core; ``side`` of a block [cells] and ``depth``, the steps of a
    superstep; None for usual values.
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
        """Return the side of the blocks of an existing store.

        Raises:
            InputError: the engine has another side.
        """
        if self.side not in (None, side):
            raise InputError(f"{folder} has blocks of side {side}, not {self.side}; side {side}, or no side, wanted")
        return side


def parse_engine(engine: "str | Engine", store: "str | Path | None") -> Engine:
    """Return an engine by its name, with the store if one is given."""
    found = Engine(engine) if isinstance(engine, str) else engine
    return found if store is None else replace(found, store=Path(store))


def side_of_blocks(engine: Engine, shape: tuple[int, ...], workers: int) -> int:
    """Return the side of a block: of the engine, or such that all workers have blocks and the blocks fit in memory."""
    if engine.side is not None:
        return engine.side
    rows, cols = shape[-2:]
    fits = math.sqrt(min(MEMORY_SHARE * free_memory() / workers / 64, 1e12))
    balanced = math.sqrt(rows * cols / (BLOCKS_PER_WORKER * workers))
    most = max(SMALLEST, min(LARGEST, fits, balanced))
    side = math.ceil(max(rows, cols) / math.ceil(max(rows, cols) / most))
    return math.ceil(side / SMALLEST) * SMALLEST


def steps_of_superstep(engine: Engine, plan: Plan, side: int) -> int:
    """Return the steps of a superstep; in a run until settled a whole number of check intervals if that fits."""
    steps = engine.depth or max(1, min(MOST_STEPS, side // (HALO_PART * max(1, reach_of(plan)))))
    if plan.duration != "settled":
        return math.ceil(plan.steps / math.ceil(plan.steps / steps)) if plan.steps else 0
    if engine.depth is None and 4 * plan.check_every * reach_of(plan) <= side:
        steps = max(steps, plan.check_every)
    return max(steps // plan.check_every * plan.check_every, min(steps, plan.check_every))


def check_worker_memory(
    engine: Engine, plan: Plan, side: int, shape: tuple[int, ...], dtype: np.dtype[np.generic], names: set[str],
    backend: str, workers: int,
) -> None:  # fmt: skip
    """Check that the blocks of all worker processes of this machine fit in the free memory.

    Arguments: ``shape`` of the state and ``names`` of all planes.

    Raises:
        InputError: the needed and the free memory.
    """
    if engine.name != "processes":
        return
    halo = halo_of(plan, steps_of_superstep(engine, plan, side))
    cells = math.prod(shape[:-2]) * math.prod(min(side, cells) + 2 * halo for cells in plan.shape)
    each = cell_bytes(plan, len(names - {"mask"}), dtype.itemsize, has_mask="mask" in names, backend=backend)
    needed = workers * (WORKER_BYTES + cells * (each + (1 + len(names)) * dtype.itemsize))
    check_memory(f"{workers} workers with blocks of {side} x {side} cells", needed, "smaller blocks wanted")
