"""explain: the plan of a template, or of each template step of a program, on a grid; nothing is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.library.entry import LibraryEntry
from cnnsim.library.explain import Explanation, blank, explain_template
from cnnsim.network import AnyTemplate
from cnnsim.planning.plan import Plan, lines_of, make_plan
from cnnsim.program.block_cache import rule_of
from cnnsim.program.file import find_program
from cnnsim.program.numbering import numbered
from cnnsim.program.program import Program, TemplateStep
from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled
from cnnsim.task import TaskOptions


@dataclass(frozen=True)
class ExplainedStep:
    """A template step: its ``number``, a description, and its ``plan``, None for packed logic."""

    number: str
    words: str
    plan: Plan | None

    @property
    def method(self) -> str:
        """How it is computed."""
        return "packed logic" if self.plan is None else self.plan.method

    @property
    def decisions(self) -> tuple[tuple[str, str], ...]:
        """The decisions and their reasons."""
        if self.plan is None:
            return (
                ("packed logic", "black and white from black and white: an AND or OR of neighbours, 64 cells a word"),
            )
        return self.plan.decisions


@dataclass(frozen=True, repr=False)
class ProgramExplanation:
    """The ``steps`` of a program that run a template; ``str`` has a line for each decision of theirs."""

    program: str
    steps: tuple[ExplainedStep, ...]

    def __repr__(self) -> str:
        if not self.steps:
            return f"{self.program} runs no template: all of its steps are cellwise or logic"
        heads = [f"step {step.number}: {step.words}" for step in self.steps]
        bodies = [lines_of([(f"  {what}", why) for what, why in step.decisions]) for step in self.steps]
        return "\n".join(line for pair in zip(heads, bodies, strict=True) for line in pair)


def explain_program(program: Program, shape: tuple[int, int] = (64, 64)) -> list[ExplainedStep]:
    """Return the plan of each template step on a grid of ``shape`` (rows, cols).

    Raises:
        InputError: a template that cannot run on such a grid.
    """
    found = []
    for number, step in numbered(program.steps):
        if isinstance(step, TemplateStep):
            plan = None
            if rule_of(program, step) is None:
                plan = make_plan(step.template, shape, step.boundary, duration=step.duration, cell=step.cell,
                                 step=step.step)  # fmt: skip
            found.append(ExplainedStep(number, str(step), plan))
    return found


@overload
def explain(
    template: LibraryEntry | AnyTemplate, picture: ArrayLike = ..., backend: str = ..., **changes: Unpack[TaskOptions]
) -> Explanation: ...
@overload
def explain(template: Program, picture: ArrayLike = ...) -> ProgramExplanation: ...
@overload
def explain(
    template: str, picture: ArrayLike = ..., backend: str = ..., **changes: Unpack[TaskOptions]
) -> Explanation | ProgramExplanation: ...
@spelled(TaskOptions)
def explain(
    template: str | LibraryEntry | AnyTemplate | Program, picture: ArrayLike = (64, 64), backend: str = "cpu",
    **changes: Unpack[TaskOptions],
) -> Explanation | ProgramExplanation:  # fmt: skip
    """Return the plan of a template, or of each template step of a program, on a grid, with its reasons.

    Arguments: ``template`` a name or an entry of the library, a program or its name ("programs/NAME" where a template
    has it too), a file, or a template of your own (without a bound on its time); ``picture`` CNN values (rows,
    cols), or only the shape (rows, cols), of which no plane is made; ``backend``, "cpu" or "opencl", whose memory is
    counted for a template; ``changes`` as in `run_transient`, for templates.

    Raises:
        InputError: no such template or program, no shape of a grid, changes of a program, or as `run_transient`.
    """
    program = find_program(template) if isinstance(template, str) else template
    if not isinstance(program, Program):
        if isinstance(template, Program) or not isinstance(template, str | LibraryEntry | AnyTemplate):
            raise InputError(f"template {shown(template)}; a template, a program or the name of one wanted")
        return explain_template(template, picture, backend, **changes)
    if changes:
        raise InputError(f"{', '.join(changes)}: {program.name!r} is a program; they go with templates")
    shape = np.asarray(picture)
    shape = blank(shape) if shape.ndim == 1 else shape
    if shape.ndim != 2:
        raise InputError(f"a picture of shape {shape.shape}; (rows, cols) wanted")
    return ProgramExplanation(program.name, tuple(explain_program(program, (shape.shape[0], shape.shape[1]))))
