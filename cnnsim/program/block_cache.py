"""Cache of a machine for the steps of its programs, by shape: bit rules, plans and compiled basic blocks."""

from collections.abc import Callable
from dataclasses import replace

from cnnsim import library
from cnnsim.backends.base import Backend
from cnnsim.network import CHUA_YANG
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule, bit_rule
from cnnsim.operations.routine import Stores
from cnnsim.planning.plan import Plan, make_plan
from cnnsim.program.basic_block import BasicBlock, basic_blocks
from cnnsim.program.numbering import numbered
from cnnsim.program.program import Program, Step, TemplateStep
from cnnsim.solver.verify_settled import is_neutral

Compiled = Callable[[Stores], Stores | None]
"""See `Backend.prepared`."""
Part = tuple[Compiled | None, BasicBlock | Step]
"""A step, or a basic block with its compiled routine, None where the steps one by one are as fast."""


class TemplateCache:
    """The rules and plans of the template steps that a machine has met."""

    def __init__(self) -> None:
        self._plans: dict[tuple[TemplateStep, tuple[int, ...]], Plan] = {}
        self._rules: dict[TemplateStep, BitRule | None] = {}

    def rule(self, program: Program, step: TemplateStep) -> BitRule | None:
        """Return the AND or OR of neighbours that a step is, or None."""
        if step not in self._rules:
            self._rules[step] = rule_of(program, step)
        return self._rules[step]

    def plan(self, step: TemplateStep, shape: tuple[int, ...]) -> Plan:
        """Return the plan of a step on planes of a shape."""
        plan = self._plans.get((step, shape))
        if plan is None:
            plan = self._plans[step, shape] = make_plan(
                step.template, shape, step.boundary, duration=step.duration, cell=step.cell,
                step=None if step.accuracy is not None else step.step, limit=_limit(step, shape),
            )  # fmt: skip
        return plan


class BlockCache:
    """The basic blocks of the programs that a machine has met, compiled by its backend."""

    def __init__(self, backend: Backend, templates: TemplateCache) -> None:
        self.backend, self.templates = backend, templates
        self._found: dict[tuple[int, tuple[int, ...]], tuple[tuple[Step, ...], list[Part]]] = {}

    def prepare(self, program: Program, shape: tuple[int, ...]) -> None:
        """Compile the blocks of all steps of a program, those inside its loops and branches too."""
        for _, step in numbered(program.steps):
            for inside in (getattr(step, "do", ()), getattr(step, "otherwise", ())):
                self.parts(program, inside, shape)
        self.parts(program, program.steps, shape)

    def parts(self, program: Program, steps: tuple[Step, ...], shape: tuple[int, ...]) -> list[Part]:
        """Return the steps; the steps of a basic block are one part, with its compiled routine."""
        found = self._found.get((id(steps), shape))
        if found is None:  # kept with the steps, so that their id stays theirs
            parts: list[Part] = [
                (self.backend.prepared(part.routine), part) if isinstance(part, BasicBlock) else (None, part)
                for part in basic_blocks(
                    program,
                    steps,
                    shape,
                    lambda step: self.templates.rule(program, step) or self._alone(step, shape),
                    fuses=self.backend.fuses,
                )
            ]
            found = self._found[id(steps), shape] = steps, parts
        return found[1]

    def _alone(self, step: TemplateStep, shape: tuple[int, ...]) -> Plan | None:
        """Return the plan of a step with an instruction, which needs only state and input, else None."""
        alone = step.bias is None and step.mask is None and step.accuracy is None and step.template.linear
        if not alone or (step.duration != "settled" and not self.backend.fuses):
            return None
        plan = self.templates.plan(step, shape)
        if plan.method == "closed form":
            return plan if step.duration == "settled" else None
        if not self.backend.fuses or plan.method != "stepped" or plan.cell != "chua-yang":
            return None
        one_stage = plan.scheme is not None and len(plan.scheme.b) == 1 and step.cell.output == CLIP
        ends = step.duration != "settled" or (plan.saturation_ends and not is_neutral(plan))
        return plan if one_stage and ends else None


def rule_of(program: Program, step: TemplateStep) -> BitRule | None:
    """Return the bit rule of a step from LLM to LLM that is an AND or OR of neighbours, else None."""
    u, x0 = step.input, step.state
    logic = isinstance(u, str) and program.memory[u] == program.memory[step.to] == "llm"
    whole = step.bias is None and step.mask is None and step.duration == "settled" and step.cell == CHUA_YANG
    if logic and whole and (x0 == u or not isinstance(x0, str)):
        return bit_rule(step.template, step.boundary, None if isinstance(x0, str) else x0)
    return None


def _limit(step: TemplateStep, grid: tuple[int, ...]) -> float | None:
    """Return the time limit of a step: of a template of the library its guaranteed time, if that is longer."""
    if not step.name or step.duration != "settled":
        return None
    entry = replace(library.load(step.name), boundary=step.boundary)
    return entry.limit((grid[-2], grid[-1]), has_mask=step.mask is not None)
