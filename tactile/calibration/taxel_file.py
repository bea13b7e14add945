"""Taxel gains as a TOML file: a matrix and its deviations for every taxel."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast, get_args

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.files import write_text
from cnnsim.support.toml_file import check_keys, take, take_tables
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import Quantity

KEYS = "quantity", "rows", "cols", "taxel"
TAXEL_KEYS = "at", "matrix", "sigma"
AXES = 3


def taxel_gains(table: Mapping[str, Any], where: str) -> TaxelGains:
    """Return the gains that a calibration's table holds.

    Raises:
        InputError: an unknown or missing key, a wrong type or value, a taxel missing or there twice.
    """
    check_keys(dict(table), KEYS, where, KEYS)
    rows, cols = (take(table, key, int, where) for key in ("rows", "cols"))
    quantity = take(table, "quantity", str, where)
    if quantity not in get_args(Quantity):
        raise InputError(f"{where}: quantity {quantity!r}, one of {', '.join(get_args(Quantity))} wanted")
    taxels = take_tables(table, "taxel", where)
    if min(rows, cols) < 1 or len(taxels) != rows * cols:
        raise InputError(f"{where}: {len(taxels)} [[taxel]] of {rows} x {cols}, one for each wanted")
    matrix, sigma = np.full((rows, cols, AXES, AXES), np.nan), np.zeros((rows, cols, AXES, AXES))
    for number, taxel in enumerate(taxels, 1):
        at = f"{where}: taxel {number}"
        check_keys(taxel, TAXEL_KEYS, at, ("at", "matrix"))
        place = take(taxel, "at", list, at)
        if not (len(place) == 2 and all(isinstance(k, int) for k in place)) or not (
            0 <= place[0] < rows and 0 <= place[1] < cols and np.isnan(matrix[place[0], place[1]]).all()
        ):
            raise InputError(f"{at}: at = {place}, [row, column] of a taxel that is not there before wanted")
        matrix[place[0], place[1]] = _square(taxel, "matrix", at)
        if "sigma" in taxel:
            sigma[place[0], place[1]] = _square(taxel, "sigma", at)
    try:
        return TaxelGains(matrix, sigma, cast(Quantity, quantity))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _square(table: Mapping[str, Any], key: str, where: str) -> Any:
    rows = take(table, key, list, where)
    numbers = all(
        isinstance(row, list) and len(row) == AXES and all(type(one) in (int, float) for one in row) for row in rows
    )
    if len(rows) != AXES or not numbers:
        raise InputError(f"{where}: {key} = {rows}, three rows of three numbers wanted")
    return np.array(rows, dtype=np.float64)


def write_taxel_gains(path: Path, made: TaxelGains) -> None:
    """Write the gains, to be read by people as well.

    Raises:
        InputError: the file cannot be written.
    """
    rows, cols = made.matrix.shape[:2]
    lines = [
        f"# A taxel's matrix times its readings (shear_x, shear_y, normal) is its {made.quantity}; sigma: deviations.",
        f'quantity = "{made.quantity}"',
        f"rows = {rows}",
        f"cols = {cols}",
    ]
    for row, col in np.ndindex(rows, cols):
        lines += ["", "[[taxel]]", f"at = [{row}, {col}]"]
        lines += [
            f"{name} = {values[row, col].tolist()!r}" for name, values in vars(made).items() if name in TAXEL_KEYS
        ]
    write_text(path, "\n".join(lines) + "\n")
