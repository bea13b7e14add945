"""Reads program files into programs, checked whole before anything runs; an error names the step."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cnnsim.library.folders import program_file
from cnnsim.network import Template, parse_boundary
from cnnsim.program.names import LocalTemplate, Names
from cnnsim.program.program import Program
from cnnsim.program.steps import read_steps
from cnnsim.support import InputError, naming
from cnnsim.support.names import check_name
from cnnsim.support.toml_file import check_keys, located, read_toml, take, take_duration

_REQUIRED = ("name", "inputs", "outputs", "step")
_OPTIONAL = ("summary", "reference", "lam", "llm", "wire", "keep", "parameters", "templates")


def load_program(
    path: str | Path,
    *,
    templates: Mapping[str, Template] | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Program:
    """Read a program file and check it.

    Arguments: ``path`` a file, or the name of a program of the library; ``templates`` and ``parameters`` replace those
    the file defines under the same names.

    Raises:
        InputError: the file, the step and what is wrong with it.
    """
    file = Path(path)
    if not file.suffix:
        file = program_file(str(path))
    data = read_toml(file, "program file")
    with naming(file):
        return program_of(data, templates or {}, parameters or {}, file)


def program_of(
    data: dict[str, Any], templates: Mapping[str, Template], parameters: Mapping[str, float], path: Path
) -> Program:
    """Return the program that the tables of a file are; the other arguments as in `load_program`.

    Raises:
        InputError: the step and what is wrong with it.
    """
    check_keys(data, (*_REQUIRED, *_OPTIONAL), required=_REQUIRED)
    with located(data, "name"):
        own_name = check_name(take(data, "name", str, "program"), "program")
    inputs, outputs = (take(data, key, list, "program") for key in ("inputs", "outputs"))
    numbers = _replaced("parameter", take(data, "parameters", dict, "program", {}), parameters)
    local = {name: _local_template(name, table) for name, table in take(data, "templates", dict, "program", {}).items()}
    _replaced("template", local, templates)
    local.update({name: (template, *local[name][1:]) for name, template in templates.items()})
    names = Names(data, numbers, local)
    with located(data, "keep"):
        kept = take(data, "keep", dict, "program", {})
        keep = {names.known(name, "keep", "lam", "llm"): names.number(v, f"keep: {name}") for name, v in kept.items()}
    with located(data, "inputs"):
        names.written |= {*(names.known(name, "inputs", "lam", "llm") for name in inputs), *keep}
    with located(data, "step"):
        steps = read_steps(data["step"], "step ", names)
    with located(data, "outputs"):
        for name in outputs:
            names.read(name, "outputs", "lam", "llm", "wire")
    return Program(
        own_name,
        take(data, "summary", str, "program", ""),
        names.memory,
        tuple(inputs),
        tuple(outputs),
        keep,
        steps,
        path,
        take(data, "reference", str, "program", ""),
        numbers,
    )


def _replaced(what: str, defined: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    for name in given:
        if name not in defined:
            raise InputError(f"no {what} {name!r} to replace; the program defines {', '.join(defined) or 'none'}")
    return {**defined, **given}


def _local_template(name: str, table: dict[str, Any]) -> LocalTemplate:
    with located(table), naming(f"templates.{name}"):
        check_name(name, "template")
        check_keys(table, ("A", "B", "z", "boundary", "duration"), required=("A",))
        template = Template(table["A"], table.get("B", 0.0), table.get("z", 0.0), name)
        boundary = parse_boundary(table.get("boundary", "zero-flux"))
        return template, boundary, take_duration(table, "template") if "duration" in table else "settled"
