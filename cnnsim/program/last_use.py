"""Last use of planes: after which step of a program no other step, and no result, needs them any more."""

from typing import assert_never

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


def names_of(step: Step) -> set[str]:
    """Return the names that a step, or one inside it, reads or writes."""
    match step:
        case TemplateStep(input=u, state=x0, bias=bias, mask=mask, to=to):
            found = {u, x0, bias, mask, to}
        case CellwiseStep(of=of, to=to):
            found = {*of, *to}
        case LogicStep(p=p, q=q, to=to):
            found = {p, q, to}
        case CopyStep(source=source, to=to):
            found = {source, to}
        case FillStep(value=value, to=to):
            found = {value, to}
        case WireStep(of=of, to=to):
            found = {of, to}
        case NumberStep(of=of, to=to):
            found = {*of, to}
        case RepeatStep(do=do):
            found = {name for inside in do for name in names_of(inside)}
        case UntilUnchangedStep(plane=plane, do=do):
            found = {plane, *(name for inside in do for name in names_of(inside))}
        case BranchStep(register=register, do=do, otherwise=otherwise):
            found = {register, *(name for inside in (*do, *otherwise) for name in names_of(inside))}
        case _:
            assert_never(step)
    return {name for name in found if isinstance(name, str)}


def used_last(program: Program) -> dict[Step, set[str]]:
    """Return for the steps of a program, not for those inside them, the planes that are not needed after them."""
    needed, found = {*program.outputs, *program.keep}, dict[Step, set[str]]()
    for step in reversed(program.steps):
        found[step] = {name for name in names_of(step) if name not in needed and program.memory[name] != "wire"}
        needed |= found[step]
    if program.steps:  # inputs that nobody reads
        found[program.steps[0]] |= set(program.inputs) - needed
    return found
