"""TOML file of taxel gains: a matrix and its standard deviations for every taxel."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from cnnsim.support import InputError, naming
from cnnsim.support.error_list import ErrorList, read_all
from cnnsim.support.files import write_text
from cnnsim.support.toml_file import line_of, located, take, take_tables
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.array_table import take_count, take_quantity
from tactile.core.frame import Quantity

KEYS = "quantity", "rows", "cols", "taxel"
TAXEL_KEYS = "at", "matrix", "sigma"
AXES = 3


def taxel_gains(table: Mapping[str, Any], where: str) -> TaxelGains:
    """Return the gains of a calibration's table.

    Raises:
        InputError: an unknown or missing key, a wrong type or value, a taxel missing or there twice.
    """
    faults = ErrorList(where)
    faults.check(table, KEYS, "", KEYS)
    shape = quantity = None
    with faults.collecting():
        *shape, quantity = read_all(
            where, *(partial(take_count, table, key, where) for key in ("rows", "cols")),
            lambda: take_quantity(table, where),
        )  # fmt: skip
    entries: list[list[Any]] = []
    for number, taxel in enumerate(take_tables(table, "taxel", where), 1):
        at = f"{where}: taxel {number}"
        faults.check(taxel, TAXEL_KEYS, f"taxel {number}", ("at", "matrix"))
        with faults.collecting():
            entries.append(
                read_all(
                    at, partial(take, taxel, "at", list, at), partial(_square, taxel, "matrix", at),
                    partial(_square, taxel, "sigma", at, np.zeros((AXES, AXES))),
                )
            )  # fmt: skip
    faults.raise_all()
    assert shape is not None
    rows, cols = shape
    if len(entries) != rows * cols:
        wanted = f"one for each wanted{line_of(table, 'rows')}"
        raise InputError(f"{where}: {len(entries)} [[taxel]] of {rows} x {cols}, {wanted}")
    matrix, sigma = np.full((rows, cols, AXES, AXES), np.nan), np.zeros((rows, cols, AXES, AXES))
    for number, (place, gains, deviations) in enumerate(entries):
        if not (len(place) == 2 and all(type(k) is int for k in place)) or not (
            0 <= place[0] < rows and 0 <= place[1] < cols and np.isnan(matrix[place[0], place[1]]).all()
        ):
            with located(table["taxel"][number], "at"):
                wanted = "[row, column] of a taxel that is not there before wanted"
                raise InputError(f"{where}: taxel {number + 1}: at = {place}, {wanted}")
        matrix[place[0], place[1]], sigma[place[0], place[1]] = gains, deviations
    with naming(where):
        return TaxelGains(matrix, sigma, cast(Quantity, quantity))


def _square(table: Mapping[str, Any], key: str, where: str, default: Any = None) -> Any:
    if default is not None and key not in table:
        return default
    rows = take(table, key, list, where)
    numbers = all(
        isinstance(row, list) and len(row) == AXES and all(type(one) in (int, float) for one in row) for row in rows
    )
    if len(rows) != AXES or not numbers:
        raise InputError(f"{where}: {key} = {rows}, three rows of three numbers wanted{line_of(table, key)}")
    return np.array(rows, dtype=np.float64)


def write_taxel_gains(path: Path, made: TaxelGains) -> None:
    """Write the gains as TOML.

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
