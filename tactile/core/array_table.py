"""Taxel arrays in tables of TOML files: reader and writer."""

import json
from collections.abc import Iterable, Mapping
from typing import Any, cast, get_args

from cnnsim.support import InputError, naming
from cnnsim.support.error_list import read_all
from cnnsim.support.toml_file import line_of, located, take, take_from_zero, take_numbers, take_positive
from tactile.core.frame import Quantity, TaxelArray


def take_array(table: Mapping[str, Any], unit: str, where: str, quantity: str | None = None) -> TaxelArray:
    """Return the taxel array of a table; its length keys end in ``unit``, "m" or "mm".

    ``quantity``: that of the table if None.

    Raises:
        InputError: as ``take`` and ``TaxelArray``.
    """
    metres = {"m": 1.0, "mm": 1e-3}[unit]
    thickness = f"thickness_{unit}"
    name, rows, cols, pitch, depth, (x, y), kind, thick, shear = read_all(
        where,
        lambda: take(table, "name", str, where),
        lambda: take_count(table, "rows", where),
        lambda: take_count(table, "cols", where),
        lambda: take_positive(table, f"pitch_{unit}", where) * metres,
        lambda: take_from_zero(table, f"depth_{unit}", where) * metres,  # a sensor of force has none
        lambda: [at * metres for at in take_numbers(table, f"origin_{unit}", 2, where, [0.0, 0.0])],
        lambda: take_quantity(table, where) if quantity is None else quantity,
        lambda: take_positive(table, thickness, where) * metres if thickness in table else None,
        lambda: take(table, "shear", bool, where, True),
    )
    with located(table), naming(where):
        return TaxelArray(name, rows, cols, pitch, depth, (x, y), kind, thick, shear)


def take_count(table: Mapping[str, Any], key: str, where: str) -> int:
    """Return a whole number of at least 1.

    Raises:
        InputError: as ``take``, or another number.
    """
    count = take(table, key, int, where)
    if count < 1:
        raise InputError(f"{where}: {key} = {count}, a whole number from 1 up wanted{line_of(table, key)}")
    return count


def take_quantity(table: Mapping[str, Any], where: str) -> Quantity:
    """Return the quantity that the taxels measure.

    Raises:
        InputError: as ``take``, or an unknown quantity.
    """
    quantity = take(table, "quantity", str, where)
    if quantity not in get_args(Quantity):
        wanted = ", ".join(get_args(Quantity))
        raise InputError(f"{where}: quantity = {quantity!r}, one of {wanted} wanted{line_of(table, 'quantity')}")
    return cast(Quantity, quantity)


def array_table(array: TaxelArray, unit: str) -> dict[str, Any]:
    """Return the table that `take_array` reads with this ``unit``."""
    scale = {"m": 1.0, "mm": 1e3}[unit]
    table: dict[str, Any] = {"name": array.name, "rows": array.rows, "cols": array.cols}
    table |= {f"pitch_{unit}": float(array.pitch) * scale, f"depth_{unit}": float(array.depth) * scale}
    if array.thickness is not None:
        table[f"thickness_{unit}"] = float(array.thickness) * scale
    if not array.shear:
        table |= {"shear": False} if unit == "m" else {"axes": ["z"]}
    return table | {f"origin_{unit}": [float(at) * scale for at in array.origin], "quantity": array.quantity}


def toml_text(top: Mapping[str, Any], fingers: Iterable[Mapping[str, Any]]) -> str:
    """Return the TOML text of texts, numbers, flags and lists, with the tables [[finger]]."""
    lines = [f"{key} = {_toml(value)}" for key, value in top.items()]
    for finger in fingers:
        lines += ["[[finger]]", *(f"{key} = {_toml(value)}" for key, value in finger.items())]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    # JSON values are TOML values, except for a bare DEL
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
