"""Groups of columns and arrays that are the readings of one finger, by their names, shapes and noise."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.layout.select import AXES
from tactile.layout.table import Table

OTHER = re.compile(r"temp|batt|volt|label|target|action|reward|done|valid|status|flag|torque|crc|check|image|joint")
"""Names of columns that are no readings."""
AXIS = re.compile(r"(?<![A-Za-z])(f[xyzn]|[xyzn])(?![A-Za-z])|(?<=[a-z])(F[XYZ]|[XYZ])(?![A-Za-z])", re.IGNORECASE)
OF_AXES = 0.25
"""Largest part of the variance of the noise (of its logarithm) within the axes, where it differs by axis."""
FINGER = re.compile(r"(finger|sensor|board|pad|hand|tip|s|f)[_\[ -]?$", re.IGNORECASE)
"""End of a name before a number that counts fingers, if another number follows."""


@dataclass
class Group:
    """Readings of one finger: ``columns`` of the layout, ``shape`` (rows, cols), number of ``axes``, and samples.

    ``values`` (samples, taxels, axes); ``order`` and ``dims`` as in a layout; ``sign`` of the normal when pressed.
    """

    name: str
    columns: str | list[int]
    values: Floats
    shape: tuple[int, int]
    order: str = ""
    dims: tuple[str, ...] = ()
    sign: int = 1


def array_group(name: str, array: Any, samples: int) -> Group | None:
    """Return an array of numbers as a group, None if it has too few samples or too many numbers a sample."""
    shape = array.shape
    times = [axis for axis, size in enumerate(shape) if size == samples] or [int(np.argmax(shape))]
    time = times[0]
    rest = [axis for axis in range(len(shape)) if axis != time]
    dims = [""] * len(shape)
    dims[time] = "time"
    if len(shape) > 2 and time == 1 and shape[0] > 1 and samples in (0, shape[1]) and len(shape) <= 4:
        dims[0] = "take"
        rest.remove(0)
    three = [axis for axis in rest if shape[axis] == 3]
    if (three and len(rest) > 1) or (three and len(rest) == 1):
        dims[three[-1]] = "axis"
        rest.remove(three[-1])
    for axis, what in zip(rest, ["taxel"] if len(rest) == 1 else ["row", "col"], strict=False):
        dims[axis] = what
    if "" in dims or shape[time] < 2 or OTHER.search(name.lower()):
        return None
    front = [axis for what in ("take", "time") for axis in range(len(shape)) if dims[axis] == what]
    moved = np.moveaxis(array.astype(np.float64), front, range(len(front))).reshape(-1, *[1] * 0, _rest(shape, front))
    numbers, order = moved.shape[1], ""
    axes = 3 if "axis" in dims else 1
    if axes == 1 and "row" not in dims:
        axes, order = _axes(moved)
    grid = (shape[dims.index("row")], shape[dims.index("col")]) if "row" in dims else _grid(numbers // axes)
    kept = tuple(dims) if dims != ["time", "taxel"] else ()
    values = (
        moved.reshape(len(moved), axes, -1).swapaxes(1, 2) if order == "axis" else moved.reshape(len(moved), -1, axes)
    )
    return Group(_finger(name), name, values, grid, order, kept)


def _rest(shape: Sequence[int], front: Sequence[int]) -> int:
    return int(np.prod([size for axis, size in enumerate(shape) if axis not in front], dtype=np.int64))


def _axes(numbers: Floats) -> tuple[int, str]:
    """Return 3 axes and their order, where the noise of the numbers a sample differs by axis; else 1.

    Where it does not, three squares of taxels are three axes.
    """
    count = numbers.shape[1]
    if count % 3:
        return 1, ""
    size = np.log(np.nanmedian(np.abs(np.diff(numbers, axis=0)), axis=0) + 1e-12)
    by_taxel, by_axis = (np.var(one, axis=1).mean() for one in (size.reshape(-1, 3).T, size.reshape(3, -1)))
    order = "axis" if by_axis < by_taxel else "taxel"
    differ = count > 3 and min(by_axis, by_taxel) < OF_AXES * np.var(size)
    return (3, order) if differ or _square(count // 3) else (1, "")


def _square(count: int) -> bool:
    return int(count**0.5 + 0.5) ** 2 == count


def _grid(taxels: int) -> tuple[int, int]:
    """Return the rows and columns nearest to a square."""
    rows = next(n for n in range(int(taxels**0.5), 0, -1) if taxels % n == 0)
    return rows, taxels // rows


def groups_by_name(columns: dict[str, Floats]) -> list[Group]:
    """Return groups of columns whose names differ in numbers and axes."""
    found: dict[str, dict[tuple[int, ...], dict[int, str]]] = {}
    for name in columns:
        marks = list(AXIS.finditer(name))
        axis = AXES[marks[-1][0].lower()] if marks else -1
        form = name if not marks else f"{name[: marks[-1].start()]}\0{name[marks[-1].end() :]}"
        places = [int(n) for n in re.findall(r"\d+", form)]
        form = re.sub(r"\d+", "\1", form)
        if form.count("\1") > 1 and (form.count("\1") > 2 or FINGER.search(form.partition("\1")[0])):
            form = form.replace("\1", str(places.pop(0)), 1)  # the first number counts fingers
        found.setdefault(form, {}).setdefault(tuple(places), {})[axis] = name
    groups = []
    for form, taxels in found.items():
        axes = {axis for one in taxels.values() for axis in one}
        whole = axes in ({-1}, {0, 1, 2}, {2}) and all(set(one) == axes for one in taxels.values())
        numbers = form.count("\1")
        if not whole or numbers > 2 or (axes == {-1} and not numbers) or form == "\1":
            continue
        names = [taxels[at][axis] for at in sorted(taxels) for axis in sorted(axes)]
        values = np.stack([columns[name] for name in names], axis=-1).reshape(-1, len(taxels), len(axes))
        rows = len({at[0] for at in taxels}) if numbers == 2 else 0
        grid = (rows, len(taxels) // rows) if rows and len(taxels) % rows == 0 else _grid(len(taxels))
        placeholders = ["{row}", "{col}"] if numbers == 2 else ["{taxel}"] * numbers
        pattern = form.replace("\0", "{axis}")
        for mark in placeholders:
            pattern = pattern.replace("\1", mark, 1)
        groups.append(Group(_finger(re.sub(r"\{\w+\}", "", pattern)), pattern, values, grid))
    return groups


def group_of_all(table: Table, columns: dict[str, Floats]) -> list[Group]:
    """Return all columns as one group, by their numbers."""
    places = [number for number, name in enumerate(table.columns) if name in columns]
    if not places:
        return []
    numbers = np.stack([columns[name] for name in columns], axis=-1)
    axes, order = _axes(numbers)
    together = places == list(range(places[0], places[-1] + 1))
    shape = (len(numbers), axes, -1) if order == "axis" else (len(numbers), -1, axes)
    values = numbers.reshape(shape).swapaxes(1, 2) if order == "axis" else numbers.reshape(shape)
    name = f"{places[0]}..{places[-1]}" if together else places
    return [Group("pad", name, values, _grid(values.shape[1]), order)]


def _finger(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-_")[:40] or "pad"


def normal_sign(normal: Floats) -> int:
    """Return -1 where the largest excursions of the normal readings from their median go down."""
    away = normal - np.nanmedian(normal, axis=0)
    low, high = (float(np.nanpercentile(away, at)) for at in (0.2, 99.8))
    return -1 if -low > 2 * high else 1
