"""What a template step comes down to on a grid: a rule on packed planes, or the plan of a transient; found once."""

from dataclasses import replace

from cnnsim import library
from cnnsim.operations.bitwise import BitRule
from cnnsim.planning.plan import Plan, make_plan
from cnnsim.program.bit_steps import rule_of
from cnnsim.program.program import Program, TemplateStep


class TemplateSteps:
    """The rules and plans of the template steps that a machine has met."""

    def __init__(self) -> None:
        self._plans: dict[tuple[TemplateStep, tuple[int, ...]], Plan] = {}
        self._rules: dict[TemplateStep, BitRule | None] = {}

    def rule(self, program: Program, step: TemplateStep) -> BitRule | None:
        """Return `rule_of` the step."""
        if step not in self._rules:
            self._rules[step] = rule_of(program, step)
        return self._rules[step]

    def plan(self, step: TemplateStep, shape: tuple[int, ...]) -> Plan:
        """Return the plan of the step on planes of a shape."""
        plan = self._plans.get((step, shape))
        if plan is None:
            plan = self._plans[step, shape] = make_plan(
                step.template, shape, step.boundary, duration=step.duration, cell=step.cell,
                step=None if step.accuracy is not None else step.step, limit=_limit(step, shape),
            )  # fmt: skip
        return plan


def _limit(step: TemplateStep, grid: tuple[int, ...]) -> float | None:
    """Return how long a step waits for rest: a template of the library for its guaranteed time, if that is longer."""
    if not step.name or step.duration != "settled":
        return None
    entry = replace(library.load(step.name), boundary=step.boundary)
    return entry.limit((grid[-2], grid[-1]), has_mask=step.mask is not None)
