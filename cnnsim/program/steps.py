"""Reads the steps of a program file: one reader for each kind, a table in, a checked step out."""

from collections.abc import Callable
from typing import Any

from cnnsim.operations import cellwise
from cnnsim.operations.global_wire import check_wire
from cnnsim.operations.logic import function_number
from cnnsim.program.names import Names
from cnnsim.program.program import (
    ARITHMETIC,
    BranchStep,
    CellwiseStep,
    CopyStep,
    FillStep,
    LogicStep,
    NumberStep,
    RepeatStep,
    Step,
    UntilUnchangedStep,
    WireStep,
)
from cnnsim.program.template_step import find_template, read_template_step
from cnnsim.support import InputError, naming
from cnnsim.support.errors import cut, not_known, shown
from cnnsim.support.limits import NUMBER, REPEATS, STEPS, check_most
from cnnsim.support.toml_file import located


def read_steps(tables: Any, prefix: str, names: Names) -> tuple[Step, ...]:
    """Turn a list of tables into steps; ``prefix`` leads their numbers in messages.

    Errors of a step, with its number and kind, are added to the faults of ``names``; a wrong step is omitted.

    Raises:
        InputError: no list of tables, or too many.
    """
    if not isinstance(tables, list) or not tables or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"{prefix.strip()}: no steps; one table or more wanted")
    check_most(len(tables), STEPS, f"{prefix.strip()}: steps")
    steps: list[Step] = []
    for i, table in enumerate(tables, start=1):
        before = len(names.faults)
        with names.faults.collecting(), located(table):
            step = _step(table, f"{prefix}{i}", names)
            steps += () if step is None else (step,)
        if len(names.faults) > before:  # count its results as written: no errors by it
            to = _list(table.get("to", []))
            names.written |= {name for name in to if isinstance(name, str) and name in names.memory}
    return tuple(steps)


def _step(table: dict[str, Any], number: str, names: Names) -> Step | None:
    """Return a step, or None if its keys are wrong; its values are then checked as far as possible."""
    kinds = [key for key in _READERS if key in table]
    if len(kinds) != 1:
        raise InputError(f"{number}: has {' and '.join(kinds) or 'none'} of {', '.join(_READERS)}; exactly one wanted")
    required, optional, read = _READERS[kinds[0]]
    where = f"{number} ({kinds[0]} {cut(str(table[kinds[0]]))})"
    if kinds[0] not in ("fill", "repeat") and not isinstance(table[kinds[0]], str):
        raise InputError(f"{where}: a name wanted")
    before = len(names.faults)
    names.faults.check(table, (kinds[0], *required, *optional), where, required)
    whole = len(names.faults) == before
    with names.faults.collecting(), located(table), naming(where):
        _check_kind(kinds[0], table[kinds[0]], names)
    if not whole:
        return None
    return read(table, where, number, names)


def _check_kind(kind: str, value: str, names: Names) -> None:
    """Refuse an unknown function or template; a separate check, because a reader may stop at another fault first."""
    if kind == "template":
        find_template(value, names)
    elif kind in ("cellwise", "logic", "wire"):
        {"cellwise": cellwise.find, "logic": function_number, "wire": check_wire}[kind](value)


def _cellwise(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    with naming(where):
        operation = cellwise.find(table["cellwise"])
    of, to, numbers = _list(table["of"]), _list(table["to"]), _list(table.get("parameters", []))
    for what, given, wanted in (
        ("inputs", of, operation.inputs),
        ("outputs", to, operation.outputs),
        ("parameters", numbers, operation.parameters),
    ):
        if len(given) != len(wanted):
            raise InputError(f"{where}: {len(given)} {what}; {len(wanted)} wanted: {', '.join(wanted) or 'none'}")
    planes = tuple(names.read(name, where, "lam") for name in of)
    results = tuple(names.write(name, where, "lam") for name in to)
    return CellwiseStep(where, operation, planes, results, tuple(names.number(value, where) for value in numbers))


def _logic(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    of = _list(table["of"])
    if len(of) not in (1, 2):
        raise InputError(f"{where}: {len(of)} planes; one or two wanted")
    p, q = (names.read(name, where, "llm") for name in (of[0], of[-1]))
    with naming(where):
        function = function_number(table["logic"])
    return LogicStep(where, function, p, q, names.write(table["to"], where, "llm"))


def _copy(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    source = names.read(table["copy"], where, "lam", "llm")
    return CopyStep(where, source, names.write(table["to"], where, "lam", "llm"))


def _fill(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    value = table["fill"]
    if isinstance(table["to"], str) and names.memory.get(table["to"]) == "wire":
        return FillStep(where, _integer(value, where, names), names.write(table["to"], where, "wire"))
    from_wire = isinstance(value, str) and names.memory.get(value) == "wire"
    number = names.read(value, where, "wire") if from_wire else names.number(value, where)
    return FillStep(where, number, names.write(table["to"], where, "lam", "llm"))


def _wire(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    of = names.read(table["of"], where, "llm")
    with naming(where):
        wire = check_wire(table["wire"])
    return WireStep(where, wire, of, names.write(table["to"], where, "wire"))


def _arithmetic(table: dict[str, Any], where: str, _number: str, names: Names) -> Step:
    function, of = table["number"], _list(table["of"])
    if function not in ARITHMETIC:
        raise not_known(f"{where}: number function", function, ARITHMETIC)
    if len(of) != 2:
        raise InputError(f"{where}: of {len(of)} numbers; two wanted")
    p, q = (_register_or_number(value, where, names) for value in of)
    return NumberStep(where, function, (p, q), names.write(table["to"], where, "wire"))


def _register_or_number(value: Any, where: str, names: Names) -> int | str:
    if isinstance(value, str) and value in names.memory:
        return names.read(value, where, "wire")
    return _integer(value, where, names)


def _repeat(table: dict[str, Any], where: str, number: str, names: Names) -> Step:
    times = _whole(table["repeat"], "times", where, names)
    return RepeatStep(where, times, read_steps(table["do"], f"{number}.", names))


def _until_unchanged(table: dict[str, Any], where: str, number: str, names: Names) -> Step:
    plane = names.read(table["until_unchanged"], where, "llm")
    limit = _whole(table.get("limit", 10_000), "limit", where, names)
    return UntilUnchangedStep(where, plane, limit, read_steps(table["do"], f"{number}.", names))


def _when(table: dict[str, Any], where: str, number: str, names: Names) -> Step:
    register = names.read(table["when"], where, "wire")
    before = set(names.written)
    do = read_steps(table["do"], f"{number}.", names)
    after_do, names.written = names.written, before
    otherwise = read_steps(table["otherwise"], f"{number} otherwise ", names) if "otherwise" in table else ()
    names.written &= after_do  # only what both ways write can be read from here on
    return BranchStep(where, register, do, otherwise)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _integer(value: Any, where: str, names: Names) -> int:
    number = names.number(value, where)
    if not number.is_integer():
        raise InputError(f"{where}: {number:g}; a whole number wanted")
    check_most(abs(number), NUMBER, where)
    return int(number)


def _whole(value: Any, what: str, where: str, names: Names) -> int:
    value = names.number(value, where) if isinstance(value, str) else value
    if isinstance(value, bool) or not isinstance(value, int | float) or not 1 <= value <= REPEATS or value % 1:
        raise InputError(f"{where}: {what} {shown(value)}; a whole number from 1 to {REPEATS} wanted")
    return int(value)


_Reader = Callable[[dict[str, Any], str, str, Names], Step]

_READERS: dict[str, tuple[tuple[str, ...], tuple[str, ...], _Reader]] = {
    "template": (("to",), ("input", "state", "bias", "mask", "boundary", "duration", "accuracy"), read_template_step),
    "cellwise": (("of", "to"), ("parameters",), _cellwise),
    "logic": (("of", "to"), (), _logic),
    "copy": (("to",), (), _copy),
    "fill": (("to",), (), _fill),
    "wire": (("of", "to"), (), _wire),
    "number": (("of", "to"), (), _arithmetic),
    "repeat": (("do",), (), _repeat),
    "until_unchanged": (("do",), ("limit",), _until_unchanged),
    "when": (("do",), ("otherwise",), _when),
}
"""Kind of step: the keys it must have, those it may have, and its reader."""
