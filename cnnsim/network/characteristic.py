"""Output characteristic y = f(x), and Cell: a cell model with its characteristic."""

from dataclasses import dataclass
from typing import Any, Literal, assert_never, get_args

import numpy as np

from cnnsim.network.cell import CellModel
from cnnsim.network.table import Table, parse_table, table_value
from cnnsim.support import Array, InputError
from cnnsim.support.errors import not_known
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number

CharacteristicKind = Literal["clip", "sign", "tanh", "table"]


@dataclass(frozen=True)
class Characteristic:
    """An output characteristic y = f(x) with values in [-1, 1].

    ``clip``: clip(p x, -1, 1), Chua and Yang's with slope p = 1, high gain with p > 1; ``sign``: -1, 0 or +1;
    ``tanh``: tanh(p x), the sigmoid; ``table``: a user's own `Table`.

    Raises:
        InputError: an unknown kind, a slope that is not positive, a table with values outside [-1, 1], no table.
    """

    kind: CharacteristicKind = "clip"
    slope: float = 1.0
    table: Table | None = None

    def __post_init__(self) -> None:
        if self.kind not in get_args(CharacteristicKind):
            raise not_known("characteristic", self.kind, get_args(CharacteristicKind))
        if not is_number(self.slope) or not 0 < self.slope < np.inf:
            raise InputError(f"characteristic {self.kind}: slope {self.slope!r}; a positive number wanted")
        if (self.kind == "table") != (self.table is not None):
            raise InputError(
                f"characteristic {self.kind!r} with table {self.table!r}; kind 'table' wants one, no other does"
            )
        if self.table is not None and self.table.bound > 1:
            raise InputError(f"characteristic: its table reaches {self.table.bound:g}; values from -1 to 1 wanted")

    def __call__(self, x: Array) -> Array:
        """Return y = f(x)."""
        match self.kind:
            case "clip":
                return np.clip(
                    x if self.slope == 1 else x * x.dtype.type(self.slope), x.dtype.type(-1), x.dtype.type(1)
                )
            case "sign":
                return np.sign(x)
            case "tanh":
                return np.tanh(x * x.dtype.type(self.slope))
            case "table":
                assert self.table is not None
                return self.table(x).astype(x.dtype)
        assert_never(self.kind)

    @property
    def slopes(self) -> tuple[float, float]:
        """Lower (<= 0) and upper bound of f'(x), without jumps (sign, step tables)."""
        if self.table is not None:
            most = max(map(abs, self.table.slopes))
            return -most, most
        return 0.0, 0.0 if self.kind == "sign" else self.slope

    @property
    def jump(self) -> float:
        """The largest jump."""
        return self.table.jump if self.table is not None else 2.0 * (self.kind == "sign")

    @property
    def keeps_outputs(self) -> bool:
        """Whether f(f(x)) = f(x)."""
        return self.kind == "sign" or self == CLIP

    def __str__(self) -> str:
        return self.kind if self.slope == 1 else f"{self.kind}, slope {self.slope:g}"


CLIP, SIGN, TANH = Characteristic(), Characteristic("sign"), Characteristic("tanh")


@spelled_class
@dataclass(frozen=True)
class Cell:
    """A cell model with its output characteristic; the default is sign in discrete time, else clip.

    Raises:
        InputError: an unknown model, or a full-range cell with a characteristic other than clip.
    """

    model: CellModel = "chua-yang"
    characteristic: Characteristic | None = None

    def __post_init__(self) -> None:
        if self.model not in get_args(CellModel):
            raise not_known("cell model", self.model, get_args(CellModel))
        if self.model == "full-range" and self.characteristic not in (None, CLIP):
            raise InputError(
                f"full-range cells have y = x; the characteristic {self.characteristic} needs chua-yang cells"
            )

    @property
    def output(self) -> Characteristic:
        """The characteristic."""
        return self.characteristic or (SIGN if self.model == "discrete-time" else CLIP)


CHUA_YANG = Cell()


def parse_cell(value: Any) -> Cell:
    """Parse a cell of a file.

    ``"discrete-time"``, or ``{ model = "chua-yang", characteristic = "tanh", slope = 2 }``, where the characteristic
    may be a table, see `parse_table`.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, Cell):
        return value
    if not isinstance(value, dict):
        return Cell(value)
    unknown = value.keys() - {"model", "characteristic", "slope"}
    if unknown:
        raise InputError(f"cell has {', '.join(sorted(unknown))}; model, characteristic, slope wanted")
    model, kind, slope = value.get("model", "chua-yang"), value.get("characteristic"), value.get("slope", 1.0)
    if isinstance(kind, dict):
        return Cell(model, Characteristic("table", slope, parse_table(kind)))
    return Cell(model, Characteristic(kind, slope) if kind is not None else None)


def cell_value(cell: Cell) -> Any:
    """Return the value of a cell in a file, the reverse of `parse_cell`."""
    if cell.characteristic is None:
        return cell.model
    table, slope = cell.characteristic.table, cell.characteristic.slope
    kind = cell.characteristic.kind if table is None else table_value(table)
    return {"model": cell.model, "characteristic": kind} | ({} if slope == 1 else {"slope": slope})
