"""Reading of program files: all steps are checked before anything runs, and an error names its step."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from cnnsim.library.catalogue import has_template
from cnnsim.library.folders import program_file, programs
from cnnsim.network import ZERO_FLUX, Boundary, Template, parse_boundary
from cnnsim.program.names import LocalTemplate, Names
from cnnsim.program.program import Program, Step
from cnnsim.program.steps import read_steps
from cnnsim.support import InputError, naming
from cnnsim.support.error_list import ErrorList, read_all
from cnnsim.support.files import check_name
from cnnsim.support.toml_file import check_keys, located, read_toml, take, take_duration

_REQUIRED = ("name", "inputs", "outputs", "step")
_KINDS: dict[str, type[Any]] = {"name": str, "inputs": list, "outputs": list, "summary": str, "reference": str}
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
        InputError: all errors of the file, each with its step.
    """
    if not isinstance(path, str | Path):
        raise InputError(f"program {path!r}; the name of one of the library, or a file, wanted")
    file = Path(path)
    if not file.suffix:
        file = program_file(str(path))
    data = read_toml(file, "program file")
    with naming(file):
        return program_of(data, templates or {}, parameters or {}, file)


def find_program(name: str) -> Program | None:
    """Return the program of a name or a file; None if it belongs to a template, or is unknown.

    Where a template and a program share a name, "programs/NAME" is the program.

    Raises:
        InputError: the program's file is wrong.
    """
    if name.endswith(".toml"):
        path = Path(name)
        return load_program(path) if "step" in read_toml(path, "template or program file") else None
    leading, _, last = name.rpartition("/")
    if leading == "programs" or (last in programs() and not has_template(last)):
        return load_program(last)
    return None


def program_of(
    data: dict[str, Any], templates: Mapping[str, Template], parameters: Mapping[str, float], path: Path
) -> Program:
    """Return the program that the tables of a file are; the other arguments as in `load_program`.

    Raises:
        InputError: all errors, each with its step.
    """
    faults = ErrorList()
    faults.check(data, (*_REQUIRED, *_OPTIONAL), required=_REQUIRED)
    found: dict[str, Any] = dict.fromkeys(("name", "inputs", "outputs"), ())
    for key, kind in _KINDS.items():
        with faults.collecting(), located(data, key):
            if key in data:
                found[key] = take(data, key, kind, "program")
                if key == "name":
                    check_name(found[key], "program")
    numbers, local = _numbers(data, parameters, faults), _local_templates(data, templates, faults)
    names = Names(data, numbers, local, faults)
    keep = _kept(data, names)
    for name in found["inputs"]:
        with faults.collecting(), located(data, "inputs"):
            names.written.add(names.known(name, "inputs", "lam", "llm"))
    names.written |= keep.keys()
    steps: tuple[Step, ...] = ()
    with faults.collecting(), located(data, "step"):
        steps = read_steps(data["step"], "step ", names) if "step" in data else ()
    for name in found["outputs"]:
        with faults.collecting(), located(data, "outputs"):
            names.read(name, "outputs", "lam", "llm", "wire")
    faults.raise_all()
    return Program(
        found["name"], found.get("summary", ""), names.memory, tuple(found["inputs"]), tuple(found["outputs"]), keep,
        steps, path, found.get("reference", ""), numbers,
    )  # fmt: skip


def _numbers(data: dict[str, Any], parameters: Mapping[str, float], faults: ErrorList) -> dict[str, Any]:
    defined: dict[str, Any] = {}
    with faults.collecting():
        defined = take(data, "parameters", dict, "program", {})
        return _replaced("parameter", defined, parameters)
    return defined


def _local_templates(
    data: dict[str, Any], templates: Mapping[str, Template], faults: ErrorList
) -> dict[str, LocalTemplate]:
    """Return the program's own templates by name; one with errors is replaced by A = 0."""
    tables: dict[str, Any] = {}
    with faults.collecting():
        tables = take(data, "templates", dict, "program", {})
    local: dict[str, LocalTemplate] = {}
    for name, table in tables.items():
        local[name] = Template(0.0), ZERO_FLUX, "settled"
        with faults.collecting():
            local[name] = _local_template(name, table)
    with faults.collecting():
        _replaced("template", local, templates)
        local.update({name: (template, *local[name][1:]) for name, template in templates.items()})
    return local


def _kept(data: dict[str, Any], names: Names) -> dict[str, float]:
    keep: dict[str, float] = {}
    table: dict[str, Any] = {}
    with names.faults.collecting():
        table = take(data, "keep", dict, "program", {})
    for name, value in table.items():
        with names.faults.collecting(), located(table, name):
            keep[names.known(name, "keep", "lam", "llm")] = names.number(value, f"keep: {name}")
    return keep


def _replaced(what: str, defined: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    for name in given:
        if name not in defined:
            raise InputError(f"no {what} {name!r} to replace; the program defines {', '.join(defined) or 'none'}")
    return {**defined, **given}


def _local_template(name: str, table: dict[str, Any]) -> LocalTemplate:
    place = f"templates.{name}"
    with located(table), naming(place):
        check_name(name, "template")
        check_keys(table, ("A", "B", "z", "boundary", "duration"), required=("A",))

    def alone(key: str) -> Any:  # a template of this alone, so that each has its line
        with located(table, key), naming(place):
            Template(**{"A": 0.0, key: table.get(key, 0.0)}, name=name)
        return table.get(key, 0.0)

    def boundary() -> Boundary:
        with located(table, "boundary"), naming(place):
            return parse_boundary(table.get("boundary", "zero-flux"))

    a, b, z, edge, duration = read_all(
        "", *(partial(alone, key) for key in ("A", "B", "z")), boundary,
        lambda: take_duration(table, place) if "duration" in table else "settled",
    )  # fmt: skip
    with located(table), naming(place):
        return Template(a, b, z, name), edge, duration
