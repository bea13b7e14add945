"""Programs on large grids: a machine whose planes lie on the disk, in the store of an engine."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cnnsim.backends.base import Backend
from cnnsim.planning.plan import Plan
from cnnsim.program.last_use import used_last
from cnnsim.program.program import Program, Step, TemplateStep
from cnnsim.program.template_steps import TemplateSteps
from cnnsim.program.words import numbered
from cnnsim.supersteps.block_plan import check_plan, wants_small_blocks
from cnnsim.supersteps.engine import Engine, parse_engine
from cnnsim.supersteps.given import signature
from cnnsim.supersteps.stored.backend import StoredBackend
from cnnsim.support import InputError, naming
from cnnsim.support.values import is_stored


def large_plans(program: Program, ways: TemplateSteps, shape: tuple[int, ...]) -> dict[Step, Plan]:
    """Return the plans of the steps that run transients, checked to be such as can be cut into blocks.

    Raises:
        InputError: the step, and why it cannot.
    """
    found = dict[Step, Plan]()
    for _, step in numbered(program.steps):
        if not isinstance(step, TemplateStep) or ways.rule(program, step) is not None:
            continue
        with naming(step.where):
            if step.accuracy is not None:
                raise InputError("an accuracy on an engine: several runs are made; a step, or no engine, wanted")
            found[step] = ways.plan(step, shape)
            check_plan(found[step])
    return found


def sleeps(plans: Mapping[Step, Plan]) -> bool:
    """Return whether blocks are to be small, so that they sleep in one of the steps."""
    return any(small_in(step, plan) for step, plan in plans.items())


def small_in(step: Step, plan: Plan) -> bool:
    """Return whether a step wants small blocks, on the backend that most use."""
    return wants_small_blocks(plan, "cpu", has_mask=getattr(step, "mask", None) is not None)


class OnEngine:
    """What a machine asks for besides the verbs of its backend when its planes lie on the disk."""

    def __init__(self, where: Backend, engine: str | Engine, store: str | Path | None, ways: TemplateSteps) -> None:
        self.backend, self._ways = StoredBackend(where, parse_engine(engine, store)), ways
        self._used_last: dict[Step, set[str]] = {}

    @contextmanager
    def running(self, program: Program, planes: Mapping[str, Any]) -> Iterator[None]:
        """Run a program on planes in a block.

        Raises:
            InputError: a step that cannot be done block by block; the store is of something else.
        """
        shape = next(iter(planes.values())).shape
        plans = large_plans(program, self._ways, shape)
        told = (program.memory, program.inputs, program.outputs, program.keep, program.steps, shape)
        place = self.backend.name, self.backend.dtype.str
        count = max(len(program.steps), 1)
        shares = {step.where: int(number.split()[0].split(".")[0]) - 1 for number, step in numbered(program.steps)}
        self._used_last = used_last(program)
        with self.backend.on.running(
            signature((place, *told), dict(planes)), shape, {where: at / count for where, at in shares.items()},
            sleeps=sleeps(plans),
            stays=any(is_stored(plane) for plane in planes.values()),
        ):  # fmt: skip
            yield

    def begins(self, step: Step) -> None:
        """Take which step comes next."""
        self.backend.on.progress.step = step.where

    def ended(self, step: Step, planes: dict[str, Any]) -> None:
        """Let go of the planes that are not needed after a step."""
        for name in self._used_last.get(step, ()):
            planes.pop(name, None)
