"""Taxel array read from a table of a TOML file that people write."""

from collections.abc import Mapping
from typing import Any, cast

from cnnsim.support import InputError
from cnnsim.support.toml_file import take, take_numbers
from tactile.core.frame import Quantity, TaxelArray


def take_array(table: Mapping[str, Any], unit: str, where: str, quantity: str | None = None) -> TaxelArray:
    """Return the taxel array that a table describes, its lengths under keys that end in ``unit``, "m" or "mm".

    ``quantity``: the table's own unless given.

    Raises:
        InputError: as ``take`` and ``TaxelArray``.
    """
    metres = {"m": 1.0, "mm": 1e-3}[unit]
    pitch, depth = (take(table, f"{key}_{unit}", float, where) * metres for key in ("pitch", "depth"))
    thick = take(table, f"thickness_{unit}", float, where) * metres if f"thickness_{unit}" in table else None
    x, y = (at * metres for at in take_numbers(table, f"origin_{unit}", 2, where, [0.0, 0.0]))
    kind = cast(Quantity, take(table, "quantity", str, where) if quantity is None else quantity)
    name, rows, cols = (take(table, "name", str, where), *(take(table, key, int, where) for key in ("rows", "cols")))
    try:
        return TaxelArray(name, rows, cols, pitch, depth, (x, y), kind, thick)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
