"""Symbol table of a program file: the memory of each name, the names written so far, parameters and templates."""

from collections.abc import Mapping
from typing import Any, get_args

from cnnsim.network import Boundary, Template
from cnnsim.planning.step import Duration
from cnnsim.program.program import ProgramMemory
from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.files import check_name
from cnnsim.support.limits import PLANES, check_most
from cnnsim.support.toml_file import in_range, located

LocalTemplate = tuple[Template, Boundary, Duration]


class Names:
    """Names declared under ``lam``, ``llm`` and ``wire``, those written so far, numbers and templates.

    The numbers are the values of the parameters; the templates are the program's own. Faults of the file are collected
    in ``faults``. The constructor adds declarations that are not names, and names declared in two memories.
    """

    def __init__(
        self, declared: Mapping[str, Any], parameters: Mapping[str, float],
        templates: Mapping[str, LocalTemplate], faults: ErrorList,
    ) -> None:  # fmt: skip
        self.memory: dict[str, ProgramMemory] = {}
        for kind in get_args(ProgramMemory):
            names: list[str] = []
            with faults.collecting(), located(declared, kind):
                names = _declared(declared, kind)
            for name in names:
                with faults.collecting(), located(declared, kind):
                    check_name(name, f"{kind}: plane or register")
                    if name in self.memory:
                        both = f"{self.memory[name]} and as {kind}"
                        raise InputError(f"{name!r} is declared as {both}; one memory wanted")
                    self.memory[name] = kind
        self.parameters, self.templates, self.faults = parameters, templates, faults
        self.written: set[str] = set()

    def known(self, name: Any, where: str, *kinds: ProgramMemory) -> str:
        """Return a declared name of one of the kinds, or raise InputError."""
        if not isinstance(name, str) or name not in self.memory:
            raise InputError(f"{where}: {shown(name)} is not declared; declared are {', '.join(self.memory) or 'none'}")
        if self.memory[name] not in kinds:
            raise InputError(f"{where}: {name!r} is in {self.memory[name]}; {' or '.join(kinds)} wanted")
        return name

    def read(self, name: Any, where: str, *kinds: ProgramMemory) -> str:
        """Return a name that a step reads, or raise InputError if no step before has written it."""
        name = self.known(name, where, *kinds)
        if name not in self.written:
            raise InputError(f"{where}: {name!r} is read before anything has been written to it")
        return name

    def write(self, name: Any, where: str, *kinds: ProgramMemory) -> str:
        """Return a name that a step writes, and record it as written."""
        name = self.known(name, where, *kinds)
        self.written.add(name)
        return name

    def number(self, value: Any, where: str) -> float:
        """Return a number, given as such or as a parameter's name."""
        if isinstance(value, str):
            if value not in self.parameters:
                known = ", ".join(self.parameters) or "none"
                raise InputError(f"{where}: no parameter {shown(value)}; defined are {known}")
            value = self.parameters[value]
        if isinstance(value, bool) or not isinstance(value, int | float) or not in_range(value):
            raise InputError(f"{where}: {shown(value)} is no finite number")
        return float(value)


def _declared(declared: Mapping[str, Any], kind: ProgramMemory) -> list[str]:
    names = declared.get(kind, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{kind} is {shown(names)}; a list of names wanted")
    check_most(len(names), PLANES, f"{kind}: names")
    return names
