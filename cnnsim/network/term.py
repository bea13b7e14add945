"""Term: a non-linear, delayed, space-variant or inter-layer part of a cell's equation, beyond A*y + B*u + z.

**One sign convention**: a difference is the neighbour minus the centre, kl minus ij. Readers of other systems' files
(`cnnsim.formats`) change the sign of others.
"""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.network.table import Table
from cnnsim.network.weights import checked_number, checked_weights, reach
from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_whole

Quantity = Literal["x", "y", "u"]
Range = tuple[float, float]


class Argument(NamedTuple):
    """Argument of a function: a neighbour's value, or its difference to a value of the cell itself."""

    neighbour: Quantity
    centre: Quantity | None = None

    def __str__(self) -> str:
        return f"{self.neighbour}_kl" + (f" - {self.centre}_ij" if self.centre else "")

    @property
    def quantities(self) -> set[str]:
        """The quantities that are read, of x, y, u."""
        return {self.neighbour, self.centre} - {None}  # type: ignore[return-value]  # None is taken out


_ARGUMENTS = {str(Argument(n, c)): Argument(n, c) for n, c in product(("y", "u", "x"), (None, "y", "u", "x"))}  # type: ignore[arg-type]  # the letters are quantities


def parse_argument(text: "str | Argument") -> Argument:
    """Parse ``"y_kl"`` or ``"u_kl - x_ij"``: kl is the neighbour, ij the cell itself.

    Raises:
        InputError: anything else.
    """
    if isinstance(text, Argument):
        return text
    try:
        return _ARGUMENTS[" ".join(text.replace("-", " - ").split())]
    except (KeyError, AttributeError) as error:
        raise InputError(f"argument {text!r}; one of {', '.join(_ARGUMENTS)} wanted") from error


@dataclass(frozen=True, eq=False)
class Term:
    """A sum over the neighbourhood that is added to the drive of a cell: sum of w(k, l) f(v) m.

    v is the argument ``of``, f the ``table`` (None: f(v) = v), m the argument ``times`` (None: 1). ``delay`` [time
    constants] is the time lag of all values; before t = 0 the state is x(0) and the input its first frame. With
    ``layer`` (counted from 0) the neighbour's value is that of another layer; values of the centre are the cell's own.
    ``weights`` (side, side) is like A; (side, side, rows, cols) has a plane for each entry.

    Raises:
        InputError: weights that are no odd square, an unknown argument, a delay that is negative.
    """

    weights: Floats = field(repr=False)
    of: Argument
    table: Table | None = None
    times: Argument | None = None
    delay: float = 0.0
    layer: int | None = None

    @spelled()
    def __init__(
        self,
        weights: ArrayLike,
        of: str | Argument = "y_kl",
        table: Table | None = None,
        times: str | Argument | None = None,
        delay: float = 0.0,
        layer: int | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "weights", checked_weights("term", "weights", weights, varying=True))
        set_(self, "of", parse_argument(of))
        if table is not None and not isinstance(table, Table):
            raise InputError(f"term: table is {table!r}; a Table wanted")
        set_(self, "table", table)
        set_(self, "times", None if times is None else parse_argument(times))
        set_(self, "delay", checked_number("term", "delay", delay))
        if self.delay < 0:
            raise InputError(f"term: delay is {delay!r}; a number of time constants >= 0 wanted")
        if layer is not None and (not is_whole(layer) or layer < 0):
            raise InputError(f"term: layer is {layer!r}; the number of a layer, from 0, wanted")
        set_(self, "layer", None if layer is None else int(layer))

    def __str__(self) -> str:
        inner = str(self.of) if self.table is None else f"f({self.of})"
        text = inner if self.times is None else f"{inner} ({self.times})"
        where = "" if self.layer is None else f" of layer {self.layer}"
        return text + where + (f", {self.delay:g} time constants ago" if self.delay else "")

    @cached_property
    def taps(self) -> tuple[tuple[int, int, Any], ...]:
        """(k, l, weight) of the non-zero entries, row by row; the weight is a number or a plane."""
        r, weights = self.weights.shape[0] // 2, self.weights
        return tuple(
            (k - r, l - r, weights[k, l] if weights.ndim == 4 else float(weights[k, l]))
            for k, l in np.ndindex(weights.shape[:2])
            if np.any(weights[k, l])
        )

    @property
    def radius(self) -> int:
        """The largest offset of a tap."""
        return reach((k, l) for k, l, _ in self.taps)

    @property
    def quantities(self) -> set[str]:
        """The quantities that the term reads, of x, y, u."""
        return self.of.quantities | (set() if self.times is None else self.times.quantities)

    @property
    def control(self) -> bool:
        """Whether the term reads the present input of the cell's own layer alone, so that it is constant in time."""
        return self.quantities == {"u"} and not self.delay and self.layer is None

    @property
    def couples(self) -> bool:
        """Whether the term reads the state or output of a neighbour or of another layer."""
        neighbours = {self.of.neighbour, *(() if self.times is None else (self.times.neighbour,))}
        return neighbours != {"u"} and (self.layer is not None or any((k, l) != (0, 0) for k, l, _ in self.taps))

    @property
    def bound(self) -> float:
        """Upper bound of the term's modulus for |u|, |y|, |x| <= 1."""
        size = (1.0 if self.of.centre is None else 2.0) if self.table is None else self.table.bound
        factor = 1.0 if self.times is None or self.times.centre is None else 2.0
        return size * factor * float(np.abs(self.weights).sum(axis=(0, 1)).max())

    @property
    def slopes(self) -> Range:
        """The smallest and the largest slope of f(v) m in v and m."""
        if self.table is None:
            return (1.0, 1.0) if self.times is None else (-4.0, 4.0)
        if self.times is None:
            return self.table.slopes
        if self.times == self.of:
            return self.table.product_slopes
        most = self.table.bound + 2 * max(map(abs, self.table.slopes))
        return -most, most

    @property
    def jump(self) -> float:
        """The largest jump of the drive when one neighbour's argument crosses an edge of a step."""
        factor = 1.0 if self.times is None else 2.0
        return 0.0 if self.table is None else factor * self.table.jump * float(np.abs(self.weights).max())
