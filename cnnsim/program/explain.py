"""How the template steps of a program would be computed on a grid; nothing is computed."""

from dataclasses import dataclass

from cnnsim.planning.plan import Plan, make_plan
from cnnsim.program.bit_steps import rule_of
from cnnsim.program.program import Program, TemplateStep
from cnnsim.program.words import numbered


@dataclass(frozen=True)
class ExplainedStep:
    """A step that runs a template: its ``number``, what it does, its ``plan``, or None where packed logic does it."""

    number: str
    words: str
    plan: Plan | None

    @property
    def method(self) -> str:
        """How it is computed."""
        return "packed logic" if self.plan is None else self.plan.method

    @property
    def decisions(self) -> tuple[tuple[str, str], ...]:
        """What was decided, and why."""
        if self.plan is None:
            return (
                ("packed logic", "black and white from black and white: an AND or OR of neighbours, 64 cells a word"),
            )
        return self.plan.decisions


def explain_program(program: Program, shape: tuple[int, int] = (64, 64)) -> list[ExplainedStep]:
    """Return what is decided for each step that runs a template, on a grid of ``shape`` (rows, cols).

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
