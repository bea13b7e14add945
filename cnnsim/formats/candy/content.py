"""The content of a CANDY ``.tem`` file as a value: what was read, nothing interpreted.

Source: the template files of the SzTAKI CNN simulators (CANDY, SimCNN, VisualMouse); no grammar of them is in print.
"""

from dataclasses import dataclass, field
from typing import Literal

from cnnsim.support import InputError

Operation = Literal[
    "feedback", "control", "nonlin_feedback", "nonlin_control", "nonlin_d", "delayed_feedback", "delayed_control"
]


@dataclass(frozen=True)
class Call:
    """An entry that names a function: ``a-`` of centre minus neighbour, ``a0`` of the neighbour, ``d`` of NONLIN_D."""

    letter: str
    of: Literal["-", "0", ""]


MatrixEntry = float | Call


@dataclass(frozen=True)
class FunctionLine:
    """A function line ``letter interpolation n x y x y ...``; interpolation 0 is step, 1 piecewise linear.

    A step function has the value y(i) for x(i-1) < v <= x(i), and keeps its last value above.
    """

    letter: str
    linear: bool
    points: tuple[tuple[float, float], ...]
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Block:
    """A matrix under its keyword. ``source`` is the layer after FROM, ``radius`` the NEIGHBORHOOD in force.

    ``argument`` and ``factor`` are the two sides of the ``x-u#`` line of NONLIN_D: the difference that goes into the
    function and the difference that multiplies its value. ``delay`` is the DELAY of a delayed block.
    """

    operation: Operation
    rows: tuple[tuple[MatrixEntry, ...], ...]
    source: int | None = None
    radius: int | None = None
    argument: str = ""
    factor: str = ""
    delay: float | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Layer:
    """The blocks of one layer; ``current`` is the bias z, None if the file has none."""

    number: int
    blocks: tuple[Block, ...]
    functions: tuple[FunctionLine, ...] = ()
    current: float | None = None
    label: str = ""
    line: int = field(default=0, compare=False)

    def function(self, letter: str) -> FunctionLine:
        """Return the function line that defines ``letter``.

        Raises:
            InputError: no line of the layer defines it.
        """
        for function in self.functions:
            if function.letter == letter:
                return function
        raise InputError(f"layer {self.number} has no function {letter!r}; it has {[f.letter for f in self.functions]}")


@dataclass(frozen=True)
class Section:
    """One template: its layers. In a script file ``title`` is what follows TEMPLATE, ``label`` what follows LABEL."""

    layers: tuple[Layer, ...]
    title: str = ""
    label: str = ""


@dataclass(frozen=True)
class Header:
    """One ``%Key: text`` comment."""

    key: str
    text: str
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class TemFile:
    """A whole file: one section, or in a script file several, which ``loop`` repeats (label, times)."""

    sections: tuple[Section, ...]
    headers: tuple[Header, ...] = ()
    comments: tuple[str, ...] = ()
    loop: tuple[int, int] | None = None

    def header(self, key: str) -> Header:
        """Return a header comment by its key, in any case; an empty one if the file has none."""
        return next((header for header in self.headers if header.key.lower() == key.lower()), Header(key, ""))
