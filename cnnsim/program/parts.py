"""Steps of a program parted into what the backend does at one go and what goes step by step; found once a shape."""

from functools import partial

from cnnsim.backends.base import Backend
from cnnsim.program.program import BranchStep, Program, RepeatStep, Step, UntilUnchangedStep
from cnnsim.program.stretch import AtOneGo, Known, Stretch, stretches
from cnnsim.program.template_steps import TemplateSteps
from cnnsim.program.words import numbered

Part = tuple[AtOneGo | None, Stretch | Step]
"""A step, or a stretch with what the backend does it with at one go, None where step by step is as good."""


class Parts:
    """The parts of the programs that a machine has met, and how their template steps are done.

    Arguments: ``backend`` that does them; ``ways`` the rules and plans of the template steps.
    """

    def __init__(self, backend: Backend, ways: TemplateSteps) -> None:
        self.backend, self.ways = backend, ways
        self._found: dict[tuple[int, tuple[int, ...]], tuple[tuple[Step, ...], list[Part]]] = {}

    def prepare(self, program: Program, shape: tuple[int, ...]) -> None:
        """Find the parts of all steps of a program, those inside its loops and branches too."""
        for _, step in numbered(program.steps):
            for inside in (step.do, step.otherwise) if isinstance(step, BranchStep) else _within(step):
                self.of(program, inside, shape)
        self.of(program, program.steps, shape)

    def of(self, program: Program, steps: tuple[Step, ...], shape: tuple[int, ...]) -> list[Part]:
        """Return the steps, those of a stretch together with what the backend does it with."""
        found = self._found.get((id(steps), shape))
        if found is None:  # with the steps, whose id is theirs as long as they are there
            known = Known(partial(self.ways.rule, program), partial(self.ways.plan, shape=shape))
            parts: list[Part] = [
                (self.backend.prepared(part.routine), part) if isinstance(part, Stretch) else (None, part)
                for part in stretches(program, steps, shape, known)
            ]
            found = self._found[id(steps), shape] = steps, parts
        return found[1]


def _within(step: Step) -> tuple[tuple[Step, ...], ...]:
    """Return the steps that a loop repeats."""
    return (step.do,) if isinstance(step, RepeatStep | UntilUnchangedStep) else ()
