"""Selection of the readings of a finger from the columns of a table.

``columns`` of a layout is one or several of:

    "S{taxel}_{axis}"     names with placeholders: {taxel}, {row}, {col} are whole numbers, {axis} is x, y or z (or n,
                          fx, fy, fz, in any case); * is any text. Sorted by row, column and taxel, then by axis
    "pressure_*"          names with * and ?, in the order of the file
    "signal[0:15]"        numbers 0 to 14 of every sample of an array
    3, "2..49"            columns by number, counted from 0; both ends are included
"""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from tactile.layout.layout import Column, FingerLayout, Layout
from tactile.layout.table import Table

AXES = {"x": 0, "y": 1, "z": 2, "n": 2, "fx": 0, "fy": 1, "fz": 2, "fn": 2}
"""Text of {axis} -> device axis."""
PLACES = re.compile(r"\{(taxel|row|col|axis)\}|\*")
RANGE = re.compile(r"(\d+)\.\.(\d+)")
SLICE = re.compile(r"(.+)\[(\d*):(\d*)\]")


class _Found(NamedTuple):
    """One array (samples, ...) with its place; None for what its name does not say."""

    values: Any
    row: int | None = None
    col: int | None = None
    taxel: int | None = None
    axis: int | None = None


def readings(table: Table, finger: FingerLayout) -> tuple[Floats, Flags | None]:
    """Return the readings (samples, chips, axes) of a finger, and the rows that are its own, None for all.

    Raises:
        InputError: a column that is missing or not numeric, or another number of readings than chips times axes.
    """
    where = f"finger {finger.board.array.name!r}: columns"
    chips, axes = finger.board.chips, finger.board.turn.shape[1]
    if finger.dims:
        values = _by_dims(table, finger, where)
    else:
        found = [one for column in finger.columns for one in _find(table, column, where)]
        values = _joined(found, axes, finger.order)
    if values.shape[1] * values.shape[2] != chips * axes:
        got = f"{values.shape[1] * values.shape[2]} numbers a sample"
        said = ", ".join(map(str, finger.columns))
        wanted = f"{chips} taxels x {axes} axes = {chips * axes} wanted"
        raise InputError(f"{where} {said!r}: {got} in {table.path.name}, {wanted}; it has {table.names}")
    return values.reshape(-1, chips, axes), _rows(table, finger)


def takes_of(table: Table, layout: Layout) -> list[tuple[str, Table]]:
    """Return the takes in a table: by groups of names that ``take`` matches, or the table itself."""
    pattern = layout.takes
    if not pattern or pattern in table.columns:
        return [("", table)]
    depth = pattern.count("/") + 1
    groups: dict[str, dict[str, Any]] = {}
    for name, one in table.columns.items():
        parts = name.split("/")
        if len(parts) > depth and all(
            re.fullmatch(_as_regex(p), q) for p, q in zip(pattern.split("/"), parts, strict=False)
        ):
            groups.setdefault("/".join(parts[:depth]), {})["/".join(parts[depth:])] = one
    if not groups:
        raise InputError(f"take {pattern!r}: no column and no group of that name; {table.path.name} has {table.names}")
    numbered = sorted(groups, key=lambda name: [int(n) for n in re.findall(r"\d+", name)])
    return [(name, Table(table.path, groups[name])) for name in numbered]


def _as_regex(pattern: str) -> str:
    return re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")


def _find(table: Table, column: Column, where: str) -> list[_Found]:
    """Return the arrays that an entry of ``columns`` names, in order."""
    if isinstance(column, int):
        return [_Found(table.numbers(column, where))]
    if (span := RANGE.fullmatch(column)) and column not in table.columns:
        return [_Found(table.numbers(n, where)) for n in range(int(span[1]), int(span[2]) + 1)]
    if "{" in column and column not in table.columns:
        return _by_places(table, column, where)
    if (part := SLICE.fullmatch(column)) and column not in table.columns:
        flat = table.numbers(part[1], where)
        flat = flat.reshape(len(flat), -1)
        return [_Found(flat[:, slice(*(int(n) if n else None for n in part.groups()[1:]))])]
    return [_Found(table.numbers(name, where)) for name in table.matching(column) or [column]]


def _by_places(table: Table, pattern: str, where: str) -> list[_Found]:
    """Return the columns whose names fit a pattern with placeholders, sorted by place."""
    expression, at = "", 0
    for place in PLACES.finditer(pattern):
        name = place[1]
        group = ".*" if name is None else f"(?P<{name}>{'|'.join(AXES)})" if name == "axis" else rf"(?P<{name}>\d+)"
        expression += re.escape(pattern[at : place.start()]) + group
        at = place.end()
    try:
        fits = re.compile(expression + re.escape(pattern[at:]), re.IGNORECASE)
    except re.error as error:
        raise InputError(f"{where} {pattern!r}: {error}; each placeholder once wanted") from error
    found = []
    for name in table.columns:
        if match := fits.fullmatch(name):
            said = match.groupdict()
            numbers = {key: int(said[key]) for key in ("row", "col", "taxel") if said.get(key) is not None}
            axis = AXES[said["axis"].lower()] if said.get("axis") is not None else None
            found.append(_Found(table.numbers(name, where), **numbers, axis=axis))
    if not found:
        raise InputError(f"{where} {pattern!r}: no such columns; {table.path.name} has {table.names}")
    return sorted(
        found, key=lambda one: tuple(-1 if at is None else at for at in (one.row, one.col, one.taxel, one.axis))
    )


def _joined(found: Sequence[_Found], axes: int, order: str) -> Floats:
    """Return the readings (samples, taxels, axes) of arrays; ``order`` counts where no name says the axis."""
    flat = [np.asarray(one.values, np.float64).reshape(len(one.values), -1) for one in found]
    if len({len(one) for one in flat}) > 1:
        lengths = ", ".join(str(n) for n in sorted({len(one) for one in flat}))
        raise InputError(f"columns of {lengths} samples for one finger; equally long ones wanted")
    if all(one.axis is not None for one in found) and axes > 1:
        named = [[one for one, at in zip(flat, found, strict=True) if at.axis == axis] for axis in range(axes)]
        sizes = [sum(one.shape[1] for one in mine) for mine in named]
        if len(set(sizes)) > 1:
            raise InputError(f"columns of {sizes[0]} x, {sizes[1]} y and {sizes[2]} z; as many of each wanted")
        return np.stack([np.concatenate(mine, axis=1) for mine in named], axis=-1)
    if all(one.axis is not None for one in found):
        flat = [one for one, at in zip(flat, found, strict=True) if at.axis == 2]
    whole = np.concatenate(flat, axis=1) if flat else np.empty((0, 0))
    if whole.shape[1] % axes:
        return whole[..., None]
    if order == "axis":
        return np.moveaxis(whole.reshape(len(whole), axes, -1), 1, 2)
    return whole.reshape(len(whole), -1, axes)


def _by_dims(table: Table, finger: FingerLayout, where: str) -> Floats:
    """Return the readings of one array whose axes ``dims`` names; takes follow one another."""
    if len(finger.columns) != 1:
        raise InputError(f"{where}: {len(finger.columns)} of them with dims; one array wanted")
    array = np.asarray(table.numbers(finger.columns[0], where), np.float64)
    dims = list(finger.dims)
    if array.ndim != len(dims):
        raise InputError(f"{where} {finger.columns[0]!r}: shape {array.shape}, dims {dims} wanted")
    first = [name for name in ("take", "time") if name in dims]
    array = np.moveaxis(array, [dims.index(name) for name in first], range(len(first)))
    array = array.reshape(-1, *array.shape[len(first) :])
    rest = [name for name in dims if name not in first]
    wanted = [name for name in ("row", "col", "taxel", "axis") if name in rest]
    array = np.moveaxis(array, [1 + rest.index(name) for name in wanted], range(1, 1 + len(wanted)))
    if finger.order == "axis" and "axis" not in rest:
        return np.moveaxis(array.reshape(len(array), finger.board.turn.shape[1], -1), 1, 2)
    return array.reshape(len(array), -1, array.shape[-1] if "axis" in rest else 1)


def _rows(table: Table, finger: FingerLayout) -> Flags | None:
    """Return which rows belong to a finger."""
    if not finger.where:
        return None
    use: Flags | None = None
    for name, value in finger.where.items():
        column = table.take(name, "where")
        mine = column == (str(value) if column.dtype.kind == "U" else value)
        use = mine if use is None else use & mine
    assert use is not None
    if not use.any():
        values = ", ".join(sorted(map(str, np.unique(column).tolist()))[:8])
        raise InputError(f"where {dict(finger.where)}: no such rows in {table.path.name}; {name} has {values}")
    return use
