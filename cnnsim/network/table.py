"""Table: a piecewise constant or piecewise linear function of one variable, as printed with non-linear templates."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cnnsim.support import Array, InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled_class


@spelled_class
@dataclass(frozen=True)
class Table:
    """A function f(v), constant beyond its ends.

    ``linear``: straight lines between the points (at[i], values[i]). ``step``: values[i] for at[i - 1] < v <= at[i],
    and the last value above the last place, so one value more than places; with ``closed`` "left" it is values[i] for
    at[i - 1] <= v < at[i], as the mirror image of a step needs.

    Raises:
        InputError: places that do not increase, a wrong number of values, values that are not finite.
    """

    kind: Literal["step", "linear"]
    at: tuple[float, ...]
    values: tuple[float, ...]
    closed: Literal["right", "left"] = "right"

    def __post_init__(self) -> None:
        if self.kind not in ("step", "linear") or self.closed not in ("right", "left"):
            raise InputError(
                f"table of kind {self.kind!r}, closed {self.closed!r}; step or linear, right or left wanted"
            )
        for name in ("at", "values"):
            try:
                object.__setattr__(self, name, tuple(float(number) for number in getattr(self, name)))
            except (TypeError, ValueError, OverflowError) as error:
                raise InputError(f"table: {name} is {shown(getattr(self, name))}; a list of numbers wanted") from error
        wanted = len(self.at) + (self.kind == "step")
        if not self.values or len(self.values) != wanted:
            raise InputError(
                f"{self.kind} table with {len(self.at)} places and {len(self.values)} values; {max(wanted, 1)} wanted"
            )
        if not np.isfinite([*self.at, *self.values]).all() or any(np.diff(self.at) <= 0):
            raise InputError(
                f"table at {list(self.at)} with {list(self.values)}; finite numbers at growing places wanted"
            )

    def __call__(self, v: Array) -> Array:
        """Return f(v), element by element."""
        if self.kind == "linear":
            return np.interp(v, self.at, self.values)
        return np.array(self.values)[np.searchsorted(self.at, v, side="left" if self.closed == "right" else "right")]

    def mirrored(self) -> "Table":
        """Return v -> f(-v), exact at the edges of steps."""
        at, values = tuple(-place for place in reversed(self.at)), tuple(reversed(self.values))
        return Table(self.kind, at, values, "left" if self.closed == "right" else "right")

    @property
    def bound(self) -> float:
        """The largest |f|."""
        return max(map(abs, self.values))

    @property
    def jump(self) -> float:
        """The largest jump; 0 for a linear table."""
        return float(np.abs(np.diff(self.values)).max(initial=0.0)) if self.kind == "step" else 0.0

    @property
    def slopes(self) -> tuple[float, float]:
        """The smallest and the largest slope, including 0 beyond the ends; 0 for a step table."""
        if self.kind == "step":
            return 0.0, 0.0
        rises = np.diff(self.values) / np.diff(self.at)
        return float(rises.min(initial=0.0)), float(rises.max(initial=0.0))

    @property
    def product_slopes(self) -> tuple[float, float]:
        """The smallest and the largest slope of v f(v)."""
        values, edges = np.array(self.values), np.array(self.at)
        if self.kind == "step":
            return float(values.min()), float(values.max())
        rises = np.diff(values) / np.diff(edges)
        ends = [values[[0, -1]], values[:-1] + edges[:-1] * rises, values[1:] + edges[1:] * rises]
        found = np.concatenate(ends)
        return float(found.min()), float(found.max())


def steps(at: Sequence[float], values: Sequence[float]) -> Table:
    """Return the step function with values[i] for at[i - 1] < v <= at[i]."""
    return Table("step", tuple(at), tuple(values))


def lines(*points: tuple[float, float]) -> Table:
    """Return the piecewise linear function through points (v, f)."""
    return Table("linear", tuple(v for v, _ in points), tuple(f for _, f in points))


def from_pairs(interpolation: int, pairs: Sequence[tuple[float, float]]) -> Table:
    """Return the table of a printed function line ``interpolation n  v1 f1  v2 f2 ...`` (CANDY, MATCNN).

    Interpolation 1 is linear, 0 steps: f_i for v_(i-1) < v <= v_i, the last value kept above v_n.
    """
    if interpolation not in (0, 1):
        raise InputError(f"interpolation {interpolation!r}; 0 (steps) or 1 (linear) wanted")
    if interpolation == 1:
        return lines(*pairs)
    places = [v for v, _ in pairs]
    if places != sorted(places):
        raise InputError(f"steps at {places}; growing places wanted")
    return steps(places[:-1], [f for _, f in pairs])


def table_value(table: Table) -> dict[str, Any]:
    """Return the value of a table in a file, the reverse of `parse_table`."""
    if table.kind == "linear":
        return {"linear": [list(point) for point in zip(table.at, table.values, strict=True)]}
    step: dict[str, Any] = {"at": list(table.at), "values": list(table.values)}
    return {"step": step | ({"closed": "left"} if table.closed == "left" else {})}


def parse_table(value: Any) -> Table:
    """Parse a table of a file.

    ``{ linear = [[v, f], ...] }`` or ``{ step = { at = [...], values = [...] } }``, the latter optionally with
    ``closed = "left"``.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, Table):
        return value
    match value:
        case {"linear": [*points], **other} if not other:
            if not all(isinstance(point, list) and len(point) == 2 for point in points):
                raise InputError(f"linear table {shown(points)}; pairs [v, f] wanted")
            return lines(*((point[0], point[1]) for point in points))
        case {"step": {"at": [*at], "values": [*values], **rest}, **other} if not other and rest.keys() <= {"closed"}:
            return Table("step", tuple(at), tuple(values), rest.get("closed", "right"))  # type: ignore[arg-type]  # checked when made
    raise InputError(
        f"table {shown(value)}; {{ linear = [[v, f], ...] }} or {{ step = {{ at = [...], values = [...] }} }} wanted"
    )
