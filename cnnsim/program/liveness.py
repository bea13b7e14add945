"""Liveness of planes and registers: the names that a step reads and writes, and the last step that uses each."""

from typing import assert_never

from cnnsim.program.numbering import numbered
from cnnsim.program.program import (
    BranchStep,
    CellwiseStep,
    CopyStep,
    FillStep,
    LogicStep,
    NumberStep,
    Program,
    RepeatStep,
    Step,
    TemplateStep,
    UntilUnchangedStep,
    WireStep,
)


def reads_and_writes(step: Step) -> tuple[set[str], set[str]]:
    """Return the names that a step reads and the names that it writes, without the steps inside it."""
    read: tuple[str | float | None, ...]
    written: tuple[str, ...]
    match step:
        case TemplateStep(input=u, state=x0, bias=bias, mask=mask, to=to):
            read, written = (u, x0, bias, mask), (to,)
        case CellwiseStep(of=of, to=to):
            read, written = of, to
        case LogicStep(p=p, q=q, to=to):
            read, written = (p, q), (to,)
        case CopyStep(source=source, to=to):
            read, written = (source,), (to,)
        case FillStep(value=value, to=to):
            read, written = (value,), (to,)
        case WireStep(of=of, to=to):
            read, written = (of,), (to,)
        case NumberStep(of=of, to=to):
            read, written = of, (to,)
        case RepeatStep():
            read, written = (), ()
        case UntilUnchangedStep(plane=plane):
            read, written = (plane,), ()
        case BranchStep(register=register):
            read, written = (register,), ()
        case _:
            assert_never(step)
    return {name for name in read if isinstance(name, str)}, set(written)


def names_of(step: Step) -> set[str]:
    """Return the names that a step, or one inside it, reads or writes."""
    return {name for _, inside in numbered((step,)) for names in reads_and_writes(inside) for name in names}


def used_last(program: Program) -> dict[Step, set[str]]:
    """Return the planes that are not needed after each top-level step of a program."""
    needed, found = {*program.outputs, *program.keep}, dict[Step, set[str]]()
    for step in reversed(program.steps):
        found[step] = {name for name in names_of(step) if name not in needed and program.memory[name] != "wire"}
        needed |= found[step]
    if program.steps:  # inputs that no step reads
        found[program.steps[0]] |= set(program.inputs) - needed
    return found
