"""Program: an analogic program as a value, its steps one class a kind; a new kind is listed in `Step`.

A program is a TOML file. It declares its memories and lists its steps, each a table with one of the keys

* ``template``: run a template; ``input``, ``state``, ``bias``, ``mask`` name planes, ``to`` the plane for the output;
* ``cellwise``: apply a per-cell operation; ``of``, ``to`` list planes, ``parameters`` lists numbers or their names;
* ``logic``: one of the 16 two-input functions; ``of`` lists two planes (or one), ``to`` names the result;
* ``copy``: a plane ``to`` another, converted where one is analog and one logic;
* ``fill``: a constant, a parameter or a wire register ``to`` every cell of a plane; a constant ``to`` a register;
* ``wire``: "any", "all" or "count" of the plane ``of`` into the wire register ``to``;
* ``number``: "add", "subtract", "multiply" or "less" (1 or 0) ``of`` two wire registers, parameters or whole numbers
  into the wire register ``to``;
* ``repeat``: the steps in ``[[step.do]]`` this many times (a number or a parameter);
* ``until_unchanged``: ``[[step.do]]`` until a logic plane comes out as it went in, at most ``limit`` times;
* ``when``: ``[[step.do]]`` if a wire register is not 0, else ``[[step.otherwise]]``.
"""

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from cnnsim.library.folders import folder
from cnnsim.network import CHUA_YANG, Boundary, Cell, Template
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.global_wire import Wire
from cnnsim.operations.logic import FUNCTIONS
from cnnsim.planning.step import Duration
from cnnsim.program.numbering import step_rows, written
from cnnsim.solver.tolerance import Accuracy

ProgramMemory = Literal["lam", "llm", "wire"]


@dataclass(frozen=True, eq=False)
class TemplateStep:
    """Run ``template`` from ``state`` (a plane, or a constant) with ``input`` and put y into ``to``.

    ``name`` is the library template's name; its guaranteed running time is used. A program's own template has no name.
    With an ``accuracy``, ``step`` is ignored.
    """

    where: str
    template: Template
    boundary: Boundary
    duration: Duration
    input: str | float | None
    state: str | float
    bias: str | None
    mask: str | None
    to: str
    cell: Cell = CHUA_YANG
    step: float | None = None
    name: str = ""
    accuracy: Accuracy | None = None

    def __str__(self) -> str:
        planes = {"u": self.input, "x(0)": self.state, "bias": self.bias, "mask": self.mask}
        said = ", ".join(f"{name} = {written(plane)}" for name, plane in planes.items() if plane is not None)
        return f"template {self.template.name}, {said}"


@dataclass(frozen=True, eq=False)
class CellwiseStep:
    """Apply a per-cell operation to LAM planes."""

    where: str
    operation: Cellwise
    of: tuple[str, ...]
    to: tuple[str, ...]
    parameters: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.operation.name} of {', '.join([*self.of, *map(written, self.parameters)])}"


@dataclass(frozen=True, eq=False)
class LogicStep:
    """Apply a two-input logic function to LLM planes."""

    where: str
    function: int
    p: str
    q: str
    to: str

    def __str__(self) -> str:
        return f"{FUNCTIONS[self.function]} of {self.p}" + ("" if self.p == self.q else f" and {self.q}")


@dataclass(frozen=True, eq=False)
class CopyStep:
    """Copy a plane; it is converted if the memories differ."""

    where: str
    source: str
    to: str

    def __str__(self) -> str:
        return f"copy of {self.source}"


@dataclass(frozen=True, eq=False)
class FillStep:
    """Set every cell of a plane, or a wire register, to a constant or (a plane only) to what a register holds."""

    where: str
    value: float | str
    to: str

    def __str__(self) -> str:
        return f"fill with {written(self.value)}"


@dataclass(frozen=True, eq=False)
class WireStep:
    """Read the global wire of an LLM plane into a register."""

    where: str
    wire: Wire
    of: str
    to: str

    def __str__(self) -> str:
        return f"{self.wire} of {self.of}, by the global wire"


ARITHMETIC: Mapping[str, Callable[[int, int], int]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "less": lambda p, q: int(p < q),
}
"""Functions of two wire registers."""


@dataclass(frozen=True, eq=False)
class NumberStep:
    """Put a function of two whole numbers, each a wire register or a constant, into a wire register."""

    where: str
    function: str
    of: tuple[int | str, int | str]
    to: str

    def __str__(self) -> str:
        return f"{self.function} {self.of[0]} and {self.of[1]}"


@dataclass(frozen=True, eq=False)
class RepeatStep:
    """Do some steps a fixed number of times."""

    where: str
    times: int
    do: "tuple[Step, ...]"

    def __str__(self) -> str:
        return f"repeat {self.times} times"


@dataclass(frozen=True, eq=False)
class UntilUnchangedStep:
    """Repeat steps until a round does not change an LLM plane; more than ``limit`` rounds are an error."""

    where: str
    plane: str
    limit: int
    do: "tuple[Step, ...]"

    def __str__(self) -> str:
        return f"until {self.plane} is unchanged, at most {self.limit} times"


@dataclass(frozen=True, eq=False)
class BranchStep:
    """Do some steps if a wire register is not 0, others if it is."""

    where: str
    register: str
    do: "tuple[Step, ...]"
    otherwise: "tuple[Step, ...]"

    def __str__(self) -> str:
        return f"when {self.register} is not 0"


Step = (
    TemplateStep
    | CellwiseStep
    | LogicStep
    | CopyStep
    | FillStep
    | WireStep
    | NumberStep
    | RepeatStep
    | UntilUnchangedStep
    | BranchStep
)


@dataclass(frozen=True, eq=False, repr=False)
class Program:
    """A checked program: every name is declared, written before it is read, and of the right kind.

    ``memory`` says where each name lives; ``inputs`` must be given at each run; ``keep`` are planes that survive from
    run to run, with the constant they start from; ``outputs`` are given back; ``parameters`` may be replaced when a
    file is loaded.
    """

    name: str
    summary: str
    memory: Mapping[str, ProgramMemory]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    keep: Mapping[str, float]
    steps: tuple[Step, ...]
    path: Path | None = None
    reference: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        given = f"{', '.join(self.inputs)} -> {', '.join(self.outputs)}"
        return f"Program({self.name!r}, {given}, {len(self.steps)} steps)"

    @property
    def shipped(self) -> bool:
        """True if its file is one of ours, not of a user's own library."""
        return self.path is not None and self.path.is_relative_to(folder())

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import facts, heading, table

        said = {"takes": ", ".join(self.inputs), "gives": ", ".join(self.outputs), "source": self.reference}
        return heading(self.name, self.summary) + facts(said) + table(step_rows(self.steps), ("step", "does", "to"))
