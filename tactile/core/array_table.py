"""Reader of a taxel array from a table of a TOML file."""

from collections.abc import Mapping
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
    name, rows, cols, pitch, depth, (x, y), kind, thick = read_all(
        where,
        lambda: take(table, "name", str, where),
        lambda: take_count(table, "rows", where),
        lambda: take_count(table, "cols", where),
        lambda: take_positive(table, f"pitch_{unit}", where) * metres,
        lambda: take_from_zero(table, f"depth_{unit}", where) * metres,  # a sensor of force has none
        lambda: [at * metres for at in take_numbers(table, f"origin_{unit}", 2, where, [0.0, 0.0])],
        lambda: take_quantity(table, where) if quantity is None else quantity,
        lambda: take_positive(table, thickness, where) * metres if thickness in table else None,
    )
    with located(table), naming(where):
        return TaxelArray(name, rows, cols, pitch, depth, (x, y), kind, thick)


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
