"""Guess of a layout from the columns of a table: times, counts, takes, and the readings of each finger."""

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.layout.groups import OTHER, Group, array_group, group_of_all, groups_by_name, normal_sign
from tactile.layout.select import AXES, RANGE
from tactile.layout.table import Table

TIME = re.compile(
    r"(^|[^a-z])(t|time\w*|\w*stamp\w*|date|secs?|seconds|msecs?|ms|us|usecs?|ns|micros|millis)([^a-z]|$)"
)
COUNT = re.compile(r"seq|frame|index|count|sample|packet|^n$|^#$|^id$")
TAKE = re.compile(r"episode|take|trial|demo|repetition|^run")
LIKELY = re.compile(r"tact|touch|force|press|taxel|skin|pillar")
"""Names of times, of sequence numbers, of takes, and of arrays of readings."""
UNIT = (("ns", r"(^|[^a-z])n(s|ano\w*)([^a-z]|$)"), ("us", r"(^|[^a-z])(u|µ)s(ecs?)?([^a-z]|$)|micro|tus"),
        ("ms", r"(^|[^a-z])ms(ecs?)?([^a-z]|$)|milli"), ("s", r"(^|[^a-z])s(ecs?|econds)?([^a-z]|$)"))  # fmt: skip
"""Unit -> names that say it."""
FASTEST = 20_000.0
"""Largest rate [1/s] that a guessed unit may give."""


@dataclass
class Guess:
    """What a table seems to hold: its columns of time, sequence and take, the unit of time, and the ``rate`` [1/s]."""

    time: str | None = None
    unit: str = "s"
    rate: float = float("nan")
    sequence: str | None = None
    take: str | None = None
    groups: list[Group] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)


def guess(table: Table) -> Guess:
    """Return what a table seems to hold.

    Raises:
        InputError: nothing in it can be readings of taxels.
    """
    found = Guess()
    if takes := _take_groups(table):
        pattern, table = takes
        found = guess(table)
        found.take = pattern
        return found
    numeric = {name: one for name, one in table.columns.items() if one.dtype.kind in "biuf"}
    flat = {name: one.astype(np.float64) for name, one in numeric.items() if one.ndim == 1 and one.size > 1}
    for name, one in table.columns.items():
        if one.ndim == 1 and TAKE.search(name.lower()) and 1 < len(np.unique(one)) <= one.size // 2:
            found.take = name
            break
    named = [name for name in flat if TIME.search(name.lower()) and _grows(flat[name], table, found.take)]
    first = [name for name in list(flat)[:1] if _grows(flat[name]) and not _counts(flat[name])]
    if named or first:
        found.time = (named or first)[0]
        found.unit, found.rate = _unit(found.time, numeric[found.time])
    found.sequence = next((n for n in flat if COUNT.search(n.lower()) and n != found.take and _counts(flat[n])), None)
    used = {found.time, found.sequence, found.take, *named}
    samples = flat[found.time].size if found.time else 0
    rest = {name: one for name, one in numeric.items() if name not in used}
    readings = {name: one for name, one in rest.items() if one.ndim > 1}
    likely = {name: one for name, one in readings.items() if LIKELY.search(name.lower())}
    found.groups = [one for name, array in (likely or readings).items() if (one := array_group(name, array, samples))]
    if not found.groups:
        singles = {name: one for name, one in flat.items() if name in rest and not OTHER.search(name.lower())}
        found.groups = groups_by_name(singles) or group_of_all(table, singles)
    if not found.groups:
        raise InputError(f"{table.path}: no readings of taxels found in columns {table.names}")
    taken = {name for group in found.groups for name in _names(table, group)}
    found.skipped = [name for name in table.columns if name not in taken | {found.time, found.sequence, found.take}]
    for group in found.groups:
        group.sign = normal_sign(group.values[..., -1])
    return found


def _take_groups(table: Table) -> tuple[str, Table] | None:
    """Return the pattern of groups that differ in a number and have the same arrays, and the first one; else None."""
    groups: dict[str, dict[str, set[str]]] = {}
    for name in table.columns:
        parts = name.split("/")
        for depth in range(1, len(parts)):
            form = re.sub(r"\d+", "*", "/".join(parts[:depth]))
            inside = groups.setdefault(form, {}).setdefault("/".join(parts[:depth]), set())
            inside.add("/".join(parts[depth:]))
    for form, takes in groups.items():
        first = next(iter(takes))
        if "*" in form and len(takes) > 1 and all(one == takes[first] for one in takes.values()):
            return form, Table(table.path, {name: table.columns[f"{first}/{name}"] for name in sorted(takes[first])})
    return None


def _names(table: Table, group: Group) -> list[str]:
    if isinstance(group.columns, list):
        return [list(table.columns)[number] for number in group.columns]
    if span := RANGE.fullmatch(group.columns):
        return list(table.columns)[int(span[1]) : int(span[2]) + 1]
    pattern = re.sub(r"\\\{(taxel|row|col)\\\}", r"\\d+", re.escape(group.columns)).replace(
        r"\{axis\}", f"({'|'.join(AXES)})"
    )
    return [name for name in table.columns if name == group.columns or re.fullmatch(pattern, name, re.IGNORECASE)]


def _grows(values: Floats, table: Table | None = None, take: str | None = None) -> bool:
    """Return whether values are times: most steps go up, except where another take begins."""
    steps = np.diff(values)
    if table is not None and take is not None and table.columns[take].size == values.size:
        steps = steps[table.columns[take][1:] == table.columns[take][:-1]]
    steps = steps[np.isfinite(steps)]
    return steps.size > 0 and (steps >= 0).mean() > 0.9 and (steps > 0).mean() > 0.3


def _counts(values: Floats) -> bool:
    steps = np.diff(values)
    return bool((values == np.floor(values)).all() and (steps == 1).mean() > 0.8)


def _unit(name: str, values: Any) -> tuple[str, float]:
    """Return the unit of a time column, by its name or size, and the samples a second."""
    steps = np.diff(values.astype(np.float64))
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else np.nan
    for unit, pattern in UNIT:
        if re.search(pattern, name.lower()) and unit != "s":
            return unit, _scale(unit) / step
    size = float(np.nanmax(np.abs(values)))

    unix = [unit for unit, most in (("ns", 1e17), ("us", 1e14), ("ms", 1e11), ("s", 1e8)) if size > most]
    if unix:
        return unix[0], _scale(unix[0]) / step
    fit = [unit for unit in ("s", "ms", "us", "ns") if 2 <= _scale(unit) / step <= FASTEST]
    unit = fit[0] if fit else "s"
    return unit, _scale(unit) / step


def _scale(unit: str) -> float:
    return {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
