"""Routines: sequences of instructions on numbered planes and registers, for compiled execution.

The CNN universal machine keeps templates, logic and steps of a program in its global analogic programming unit and
executes them without a host (Roska and Chua, IEEE Trans. CAS-II 40 (1993) 163). A routine is a basic block of a program
in that form. Planes of each memory and registers are numbered separately; each is written once.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from cnnsim.operations.cellwise import Cellwise


class Op(IntEnum):
    """Operations: ``to``, ``p``, ``q`` are numbers of planes or registers, ``by`` is a constant of the instruction.

    LLM planes: ``LOGIC`` (by a function's number), ``NEIGHBOURHOOD`` of p (by a rule and a boundary), ``BLACK_ABOVE`` 0
    of the LAM plane p, ``SHADE`` (by a number, above 0 is black), ``SHADE_BY`` the register p. LAM planes: ``VALUES``
    of the LLM plane p, ``CONSTANT`` (by a number), ``CONSTANT_BY`` the register p, ``SETTLE`` from state p with input q
    (by a plan in closed form), ``CLIP`` of p. Registers: ``COUNT``, ``ANY``, ``ALL`` of the LLM plane p, ``NUMBER`` (by
    a whole number), ``ADD``, ``SUBTRACT``, ``MULTIPLY``, ``LESS`` of p and q. Only of backends with `Backend.fuses`:
    ``STEPS`` from LAM plane p with input q (by a stepped plan; of a settled end only the output counts), ``CELLWISE``
    (by a `FusedCellwise`).
    """

    LOGIC = 0
    NEIGHBOURHOOD = 1
    BLACK_ABOVE = 2
    SHADE = 3
    SHADE_BY = 4
    VALUES = 5
    CONSTANT = 6
    CONSTANT_BY = 7
    SETTLE = 8
    CLIP = 9
    COUNT = 10
    ANY = 11
    ALL = 12
    NUMBER = 13
    ADD = 14
    SUBTRACT = 15
    MULTIPLY = 16
    LESS = 17
    STEPS = 18
    CELLWISE = 19


class Instruction(NamedTuple):
    """One operation with its operands (see `Op`)."""

    op: Op
    to: int
    p: int = 0
    q: int = 0
    by: Any = None


class FusedCellwise(NamedTuple):
    """A cellwise operation on numbered LAM planes."""

    operation: Cellwise
    of: tuple[int, ...]
    to: tuple[int, ...]
    parameters: tuple[float, ...]


class Stores(NamedTuple):
    """One value for each kind of store: ``llm`` and ``lam`` planes, ``wire`` registers."""

    llm: Any
    lam: Any
    wire: Any


@dataclass(frozen=True, eq=False)
class Routine:
    """Instructions on planes of ``shape``: ``sizes`` of the stores, numbers of inputs and results."""

    shape: tuple[int, ...]
    instructions: tuple[Instruction, ...]
    sizes: Stores
    given: Stores
    results: Stores
