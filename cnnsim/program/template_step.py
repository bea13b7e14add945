"""Reads the step that runs a template, one of the library or one of the program's own."""

from typing import Any

from cnnsim import library
from cnnsim.network import CHUA_YANG, Boundary, Cell, Template, parse_boundary
from cnnsim.planning.step import Duration
from cnnsim.program.names import Names
from cnnsim.program.program import Step, TemplateStep
from cnnsim.solver.tolerance import Accuracy, read_accuracy
from cnnsim.support import InputError, naming
from cnnsim.support.toml_file import take_duration


def read_template_step(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    """Return the step of a table with the key ``template``.

    Raises:
        InputError: the template is unknown, or a plane that it needs is missing.
    """
    with naming(where):
        template, boundary, duration, u, x0, cell, step, accuracy = find_template(table["template"], names)
    u = table.get("input", u)
    if template.reads_input and u is None:
        raise InputError(f"{where}: no 'input', but the template has a B; the name of a plane or a number wanted")
    x0 = table.get("state", u if x0 == "picture" else None if x0 == "given" else x0)
    if x0 is None:
        raise InputError(f"{where}: no 'state'; the name of a plane or a number for x(0) wanted")
    with naming(where):
        boundary = parse_boundary(table.get("boundary", boundary))
    return TemplateStep(
        where,
        template,
        boundary,
        take_duration(table, where) if "duration" in table else duration,
        names.read(u, where, "lam", "llm") if isinstance(u, str) else None if u is None else names.number(u, where),
        names.read(x0, where, "lam", "llm") if isinstance(x0, str) else names.number(x0, where),
        names.read(table["bias"], where, "lam", "llm") if "bias" in table else None,
        names.read(table["mask"], where, "lam", "llm") if "mask" in table else None,
        names.write(table["to"], where, "lam", "llm"),
        cell,
        step,
        "" if table["template"] in names.templates else table["template"],
        read_accuracy(table, where) or accuracy,
    )


def find_template(
    name: str, names: Names
) -> tuple[Template, Boundary, Duration, Any, Any, Cell, float | None, Accuracy | None]:
    """Return template, boundary, duration, what u and x(0) are if the step does not say (None: it must), cell, step,
    accuracy.

    A program's own templates are Chua-Yang cells.
    """
    if name in names.templates:
        return (*names.templates[name], None, None, CHUA_YANG, None, None)
    entry = library.load(name)
    template = entry.template
    if entry.frame_time:
        raise InputError(f"template {name!r} takes a sequence of pictures, a step has one")
    u = entry.input if isinstance(entry.input, int | float) else None
    x0 = 0.0 if entry.initial_state == "any" else entry.initial_state
    return template, entry.boundary, entry.duration, u, x0, entry.cell, entry.step, entry.accuracy
