"""Known loads of a calibration from a CSV table with their times, and the mean readings under each."""

from pathlib import Path

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.calibration.from_weights import KnownLoads
from tactile.core.label_lines import read_lines

GRAVITY = 9.80665e-3
"""[N] weight of a gram: standard gravity."""
TIMES = "from_s", "to_s"
FORCES = "q_n", "r_n", "f_n"
PLACE = "x_mm", "y_mm"
MOVES = 0.05
"""Largest difference of the two halves of an interval, over the largest reading."""


def read_weights(path: Path) -> tuple[Floats, KnownLoads]:
    """Return the intervals (n, 2) [s] and the loads of a table, one a row.

    Columns: ``from_s``, ``to_s``; ``grams`` or ``f_n``; optionally ``q_n``, ``r_n`` and ``x_mm``, ``y_mm``.

    Raises:
        InputError: no such file, an unknown or missing column, a cell that is no number, times that do not grow.
    """
    rows, fields = read_lines(path, "weights")
    names = [name.strip() for name in fields]
    known = {*TIMES, *FORCES, *PLACE, "grams"}
    if not {*TIMES} <= {*names} or not {*names} <= known or ("grams" in names) == ("f_n" in names):
        raise InputError(
            f"{path}: columns {', '.join(names)}; from_s, to_s, one of grams and f_n, and optionally q_n, r_n, x_mm,"
            " y_mm wanted"
        )
    if not rows or (("x_mm" in names) != ("y_mm" in names)):
        raise InputError(f"{path}: {len(rows)} loads, {'one' if rows else 'no'} of x_mm and y_mm; some loads wanted")
    columns = {
        name: np.array([_number(row[field], f"{path}: line {n}: {name}") for n, row in enumerate(rows, 2)])
        for name, field in zip(names, fields, strict=True)
    }
    zero = np.zeros(len(rows))
    pressing = columns["f_n"] if "f_n" in columns else columns["grams"] * GRAVITY
    forces = np.stack([columns.get("q_n", zero), columns.get("r_n", zero), pressing], axis=-1)
    places = np.stack([columns[name] for name in PLACE], axis=-1) * 1e-3 if "x_mm" in columns else None
    times = np.stack([columns[name] for name in TIMES], axis=-1)
    if not (times[:, 1] > times[:, 0]).all():
        n = int((times[:, 1] > times[:, 0]).argmin())
        raise InputError(
            f"{path}: row {n + 2}: from {times[n, 0]:g} to {times[n, 1]:g} s, an end after its start wanted"
        )
    return times, KnownLoads(forces, places)


def _number(cell: str | None, where: str) -> float:
    try:
        value = float(cell or "")
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{where} {cell!r}, a number wanted")
    return value


def steady_means(t: Floats, values: Floats, times: Floats, where: str) -> Floats:
    """Return the mean readings (m, rows, cols, 3) of the intervals ``times`` (m, 2) [s].

    Arguments: ``t`` (n,) [s]; ``values`` (n, rows, cols, 3), NaN where a taxel did not read.

    Raises:
        InputError: an interval without readings of every taxel, or in which they move.
    """
    means = []
    for start, stop in times:
        use = values[(t >= start) & (t <= stop)]
        name = f"{where}: {start:g} to {stop:g} s"
        if len(use) < 2 or np.isnan(use).all(axis=0).any():
            raise InputError(f"{name}: {len(use)} frames, at least 2 with readings of every taxel wanted")
        first, second = (np.nanmean(part, axis=0) for part in np.array_split(use, 2))
        error = np.nanstd(use, axis=0) / np.sqrt(len(use))
        far = np.abs(second - first) - 6 * error
        if far.max() > MOVES * np.abs(use).max():
            raise InputError(f"{name}: the readings move by {far.max():.3g}; a constant load wanted")
        means.append(np.nanmean(use, axis=0))
    return np.array(means)
