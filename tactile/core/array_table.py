"""Taxel array read from a table of a TOML file that people write."""

from collections.abc import Mapping
from typing import Any, cast

from cnnsim.support import InputError
from cnnsim.support.toml_file import take
from tactile.core.frame import Quantity, TaxelArray


def take_array(
    table: Mapping[str, Any], pitch: float, depth: float, origin: list[float], quantity: str, where: str
) -> TaxelArray:
    """Return the taxel array with the table's ``name``, ``rows`` and ``cols``, lengths in [m].

    Raises:
        InputError: as ``take`` and ``TaxelArray``.
    """
    name, rows, cols = (take(table, "name", str, where), *(take(table, key, int, where) for key in ("rows", "cols")))
    try:
        return TaxelArray(name, rows, cols, pitch, depth, (origin[0], origin[1]), cast(Quantity, quantity))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
