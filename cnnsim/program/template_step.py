"""Reads the step that runs a template, one of the library or one of the program's own."""

from typing import Any

from cnnsim import library
from cnnsim.network import CHUA_YANG, Boundary, Cell, Template, parse_boundary
from cnnsim.planning.duration import Duration
from cnnsim.program.program import Step, TemplateStep
from cnnsim.program.scope import Scope
from cnnsim.support import InputError


def read_template_step(table: dict[str, Any], where: str, _number: str, scope: Scope) -> Step:
    """Return the step of a table with the key ``template``.

    Raises:
        InputError: no such template, or no plane where it needs one.
    """
    names = scope.names
    template, boundary, duration, u, x0 = _find_template(table["template"], where, scope)
    cell, step = _cell_and_step(table["template"], scope)
    u = table.get("input", u)
    if template.reads_input and u is None:
        raise InputError(f"{where}: the template has a B, so 'input' must name a plane")
    x0 = table.get("state", u if x0 == "picture" else None if x0 == "given" else x0)
    if x0 is None:
        raise InputError(f"{where}: 'state' must name the plane, or be the number, that x(0) is")
    try:
        boundary = parse_boundary(table.get("boundary", boundary))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    return TemplateStep(
        where,
        template,
        boundary,
        table.get("duration", duration),
        names.read(u, where, "lam", "llm") if isinstance(u, str) else None if u is None else names.number(u, where),
        names.read(x0, where, "lam", "llm") if isinstance(x0, str) else names.number(x0, where),
        names.read(table["bias"], where, "lam", "llm") if "bias" in table else None,
        names.read(table["mask"], where, "lam", "llm") if "mask" in table else None,
        names.write(table["to"], where, "lam", "llm"),
        cell,
        step,
        "" if table["template"] in scope.templates else table["template"],
    )


def _cell_and_step(name: str, scope: Scope) -> tuple[Cell, float | None]:
    """Return what a template of the library asks for; a program's own templates are Chua-Yang cells."""
    if name in scope.templates:
        return CHUA_YANG, None
    entry = library.load(name)
    return entry.cell, entry.step


def _find_template(name: str, where: str, scope: Scope) -> tuple[Template, Boundary, Duration, Any, Any]:
    """Return template, boundary, duration, and what u and x(0) are if the step does not say (None: it must)."""
    if name in scope.templates:
        return (*scope.templates[name], None, None)
    try:
        entry = library.load(name)
        template = entry.template
        if entry.frame_time:
            raise InputError(f"template {name!r} takes a sequence of pictures, a step has one")
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    u = entry.input if isinstance(entry.input, int | float) else None
    x0 = 0.0 if entry.initial_state == "any" else entry.initial_state
    return template, entry.boundary, entry.duration, u, x0
