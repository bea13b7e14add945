"""How a program would lie on the disk on an engine: its blocks, its planes and their bytes; nothing is computed."""

from dataclasses import dataclass
from math import prod

from cnnsim.program.last_use import names_of, used_last
from cnnsim.program.on_engine import large_plans, sleeps, small_in
from cnnsim.program.program import Program, Step, UntilUnchangedStep
from cnnsim.program.template_steps import TemplateSteps
from cnnsim.program.words import numbered
from cnnsim.supersteps.block_plan import halo_of, reach_of
from cnnsim.supersteps.depth import first_depth
from cnnsim.supersteps.engine import Engine, side_of_blocks, worker_bytes
from cnnsim.support.memory import in_words
from cnnsim.workers.base import cores


@dataclass(frozen=True)
class LargeProgram:
    """What a program takes on an engine: ``side`` of its ``blocks`` (down, across), ``workers``, bytes of each.

    ``planes`` and ``disk_bytes``: at most on the disk at a time, those that a transient goes on by among them.
    """

    blocks: tuple[int, int]
    side: int
    workers: int
    worker_bytes: float
    planes: int
    disk_bytes: float

    @property
    def lines(self) -> tuple[tuple[str, str], ...]:
        """What was found, in words."""
        down, across = self.blocks
        return (
            ("blocks", f"{down} x {across} of at most {self.side} x {self.side} cells, on {self.workers} workers"),
            (
                "memory",
                f"{in_words(self.worker_bytes)} a worker at most, {in_words(self.workers * self.worker_bytes)} in all",
            ),
            (
                "disk",
                f"at most {self.planes} planes at a time, {in_words(self.disk_bytes)}; logic planes have a bit a cell",
            ),
        )


def explain_large(
    program: Program, shape: tuple[int, int], engine: Engine, itemsize: int = 4, backend: str = "cpu"
) -> LargeProgram:
    """Return what a program takes on a grid of ``shape`` (rows, cols) on an engine, in numbers of ``itemsize`` bytes.

    Arguments: ``backend``, "cpu" or "opencl", on which its workers compute.

    Raises:
        InputError: a step that cannot be cut into blocks.
    """
    plans = large_plans(program, TemplateSteps(), shape)
    workers = engine.workers or cores()
    side = side_of_blocks(engine, shape, workers, sleeps=sleeps(plans))
    needed = 0.0
    for step, plan in plans.items():
        halo = halo_of(
            plan, engine.depth or first_depth(side, reach_of(plan), sleeps=small_in(step, plan)), checked=True
        )
        given = sum(isinstance(getattr(step, name), str) for name in ("input", "bias"))
        has_mask = getattr(step, "mask", None) is not None
        needed = max(needed, worker_bytes(plan, side, halo, 1, itemsize, given, has_mask=has_mask, backend=backend))
    planes, size = _most(program, set(plans), itemsize)
    down, across = (-(-cells // side) for cells in shape)
    return LargeProgram((down, across), side, workers, needed, planes, size * prod(shape))


def _most(program: Program, transients: set[Step], itemsize: int) -> tuple[int, float]:
    """Return the most planes at a time, and their bytes a cell, with those that a step makes before it lets go."""
    size = {name: {"lam": float(itemsize), "llm": 1 / 8, "wire": 0.0}[kind] for name, kind in program.memory.items()}
    there, last = {*program.inputs, *program.keep}, used_last(program)
    planes, most = len(there), sum(map(size.__getitem__, there))
    for step in program.steps:
        inside = [one for _, one in numbered((step,))]
        loops = sum(isinstance(one, UntilUnchangedStep) for one in inside)  # each holds a plane to compare with
        made = loops + max(2 if one in transients else 1 for one in inside)
        there |= {name for name in names_of(step) if size[name]}
        states = loops / 8 + max(2 * itemsize if one in transients else _written(one, size) for one in inside)
        planes, most = max(planes, len(there) + made), max(most, sum(map(size.__getitem__, there)) + states)
        there -= last[step]
    return planes, most


def _written(step: Step, size: dict[str, float]) -> float:
    """Return the bytes a cell of the planes that a step writes, while those of that name are still there."""
    to = getattr(step, "to", ())
    return sum(size[name] for name in ([to] if isinstance(to, str) else to))
