"""Text of a guessed layout, with what was found in the file as comments."""

import json

import numpy as np

from cnnsim.support import Floats
from tactile.core.noise import NORMAL_MAD
from tactile.layout.groups import Group
from tactile.layout.guess import Guess
from tactile.layout.table import Table

SHOWN = 40
"""Largest number of columns that are listed."""
ASK = "(?) "
"""Mark of a guess that only the maker of the array can confirm."""


def layout_text(table: Table, found: Guess) -> str:
    """Return the TOML text of a layout for a table; lines with (?) are to be checked."""
    lines = [f"# Layout of {table.path.name}, guessed by `tactile layout`. Lines with (?) are to be checked.", "#"]
    lines += [f"# {note}" for note in table.notes]
    lines += ["# column, samples, lowest, highest, idle noise (of the steps from one sample to the next)"]
    lines += [f"#   {line}" for line in _columns(table)]
    lines += [
        "",
        f"title = {json.dumps(table.path.stem)}",
        'protocol = "csv"             # of the board on a port, for `tactile live`',
    ]
    lines += ["", "[layout]", *_times(found)]
    lines += [f"topic = {json.dumps(table.topic)}"] if table.topic else []
    if found.skipped:
        lines += [f"# skipped: {', '.join(found.skipped[:SHOWN])}"]
    for group in found.groups:
        lines += ["", *_finger_lines(group)]
    return "\n".join(lines) + "\n"


def _columns(table: Table) -> list[str]:
    """Return a line on each column: its shape, range and idle noise."""
    lines = []
    for name, one in list(table.columns.items())[:SHOWN]:
        size = " x ".join(map(str, one.shape))
        if one.dtype.kind not in "biuf":
            words = np.unique(one)
            lines.append(f"{name}: {size}, texts such as {json.dumps(str(words[0]))}")
            continue
        numbers = one.astype(np.float64)
        known = numbers[np.isfinite(numbers)]
        lost = f", {numbers.size - known.size} missing" if known.size < numbers.size else ""
        extent = f"{known.min():.6g}, {known.max():.6g}" if known.size else "no numbers"
        lines.append(f"{name}: {size}, {extent}, {_noise(numbers):.2g}{lost}")
    more = len(table.columns) - SHOWN
    return [*lines, f"and {more} columns more"] if more > 0 else lines


def _noise(values: Floats) -> float:
    """Return the robust deviation of the steps from one sample to the next, along the longest axis."""
    steps = np.abs(np.diff(values, axis=int(np.argmax(values.shape))))
    steps = steps[np.isfinite(steps)]
    return float(np.median(steps)) / NORMAL_MAD / 2**0.5 if steps.size else 0.0


def _times(found: Guess) -> list[str]:
    if found.time is None:
        lines = [f"rate_hz = 100                # {ASK}samples a second: no column of times was found"]
    else:
        said = f"{found.rate:.6g} samples/s"
        lines = [f"time = {json.dumps(found.time)}", f"time_unit = {json.dumps(found.unit):<18} # {said}"]
    if found.sequence is not None:
        lines.append(f"sequence = {json.dumps(found.sequence)}")
    if found.take is not None:
        lines.append(f"take = {json.dumps(found.take)}")
    return lines


def _finger_lines(group: Group) -> list[str]:
    """Return the lines of a [[finger]]."""
    taxels, axes = group.values.shape[1:]
    rows, cols = group.shape
    low, high = np.nanmin(group.values), np.nanmax(group.values)
    sign = "-" if group.sign < 0 else ""
    turned = f'["x", "y", "{sign}z"]' if axes == 3 else f'["{sign}z"]'
    why = "the largest changes of the normal go down" if sign else "positive when pressed"
    lines = [
        "[[finger]]",
        f"name = {json.dumps(group.name)}",
        f"rows = {rows:<22}# {ASK}{taxels} taxels, row by row",
        f"cols = {cols}",
        f"pitch_mm = 4.0               # {ASK}between neighbouring taxels",
        "depth_mm = 0.0               # of taxels under a cover that measure strain or stress",
        f'quantity = "force"           # {ASK}or strain, stress (after the gains)',
        f"columns = {json.dumps(group.columns)}",
    ]
    if group.order:
        lines.append(f"order = {json.dumps(group.order):<21}# {ASK}numbers taxel by taxel, or axis by axis")
    if group.dims:
        lines.append(f"dims = {json.dumps(list(group.dims))}")
    lines.append(f"axes = {turned:<22}# {ASK}{why}{'' if axes == 3 else '; the normal alone'}")
    lines.append(
        f"gains = [1.0, 1.0]           # {ASK}N per unit of the file: shear, normal; it has {low:.4g} to {high:.4g}"
    )
    return lines
