"""Frames of a foreign table, by its layout."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from cnnsim.support.limits import one_line
from tactile.core.source import FrameStream, Provenance
from tactile.layout.layout import UNITS, FingerLayout, Layout
from tactile.layout.select import readings, takes_of
from tactile.layout.table import Table, read_table
from tactile.sources.columns import ColumnFrames
from tactile.sources.stamps import UNIX, counted, settled
from tactile.wire.description import Board

PAUSE = 1.0
"""[s] Pause between two takes of one file, which ends events and starts a new tare."""
MOST_TAKES = 8
"""Largest number of takes that a note lists."""


def read_foreign(path: Path, layout: Layout) -> FrameStream:
    """Return the frames of a file of another program by its layout.

    Takes of one file follow one another with `PAUSE` between them.

    Raises:
        InputError: the file does not have what the layout names, or times that cannot be repaired.
    """
    with one_line(path, "a table"):
        table = read_table(path, layout)
        try:
            takes = [part for name, one in takes_of(table, layout) for part in _takes(one, layout, name)]
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
    notes, starts, fingers, start, at = list(table.notes), [], [], takes[0].start, 0.0
    for take in takes:
        for note in take.notes:
            notes += [note] if note not in notes else []
        starts.append(f"{take.name} from {at:.3f} s")
        for columns in take.fingers:
            columns["t_s"] = columns["t_s"] + at
        fingers.append(take.fingers)
        at = max(float(one["t_s"][-1]) for one in take.fingers if one["t_s"].size) + PAUSE
    if len(takes) > 1:
        more = f" and {len(starts) - MOST_TAKES} more" if len(starts) > MOST_TAKES else ""
        notes.append(f"{len(takes)} takes, one after another: {', '.join(starts[:MOST_TAKES])}{more}")
    joined = [_joined([take[number] for take in fingers]) for number in range(len(layout.fingers))]
    _place(joined)
    notes += [
        line for one, finger in zip(joined, layout.fingers, strict=True) if (line := _skipped(table, finger, one))
    ]
    known = Provenance(not layout.tared, (), start, layout.text)
    frames = ColumnFrames(joined)
    title = layout.title or path.stem
    return FrameStream(title, layout.arrays, layout.modulus, len(frames), frames, known, notes=tuple(notes))


class _Take:
    """One take: columns of each finger, the Unix time [ns] of its first sample or None, and notes."""

    def __init__(self, name: str, fingers: list[dict[str, Any]], start: int | None, notes: list[str]) -> None:
        self.name, self.fingers, self.start, self.notes = name, fingers, start, notes


def _takes(table: Table, layout: Layout, name: str) -> list[_Take]:
    """Return the takes of a table: the parts in which the column ``take`` is constant."""
    found = [readings(table, finger) for finger in layout.fingers]
    rows = len(found[0][0])
    label = np.zeros(rows, np.int64)
    names = [name or "0"]
    if layout.takes in table.columns:
        column = table.take(layout.takes, "take")
        if len(column) != rows:
            raise InputError(f"take {layout.takes!r} of {len(column)} samples, {rows} wanted")
        label = np.concatenate([[0], np.cumsum(column[1:] != column[:-1])])
        names = [str(column[n]) for n in np.unique(label, return_index=True)[1]]
    elif any("take" in finger.dims for finger in layout.fingers):
        finger = layout.fingers[0]
        count = table.take(finger.columns[0], "take").shape[finger.dims.index("take")]
        label = np.repeat(np.arange(count), rows // count)
        names = [str(n) for n in range(count)]
    keep = np.arange(rows)
    clock = _Clock(table, layout, rows)
    out = []
    for number, one in enumerate(names):
        mine = keep[label == number][layout.skip_rows :]
        if mine.size:
            columns, notes = [], []
            times, note = clock.times(mine)
            notes += [note] if note else []
            for finger, (values, own) in zip(layout.fingers, found, strict=True):
                if len(values) != rows or (own is not None and own.size != rows):
                    raise InputError(f"finger {finger.board.array.name!r}: {len(values)} samples, {rows} wanted")
                use = mine if own is None else mine[own[mine]]
                columns.append(_columns(finger.board, values[use], times[np.searchsorted(mine, use)], clock, use))
            out.append(_Take(one, columns, clock.start(mine), notes))
    if not out:
        raise InputError(f"no samples in {table.path.name} after skip_rows = {layout.skip_rows}")
    return out


class _Clock:
    """Times of the samples of a table: its time column, the device's clock, sequence numbers and the rate."""

    def __init__(self, table: Table, layout: Layout, rows: int) -> None:
        self._layout, self._rows = layout, rows
        self._stamps = self._column(table, layout.time, "time")
        self.device = self._column(table, layout.device_time, "device_time")
        self.sequence = self._column(table, layout.sequence, "sequence")

    def _column(self, table: Table, name: str | int | None, what: str) -> Any:
        if name is None:
            return None
        found = table.numbers(name, what).reshape(-1)
        if len(found) == 0 or self._rows % len(found):
            raise InputError(f"{what} {name!r} of {len(found)} samples, {self._rows} wanted")
        return np.tile(found, self._rows // len(found))  # one time axis of several takes

    def start(self, rows: Integers) -> int | None:
        """Return the Unix time [ns] of the first of these rows, None if it is unknown."""
        if self._stamps is None or not np.isfinite(self._stamps[rows[0]]):
            return None
        first = self._stamps[rows[0]].item()
        ns = int(first * UNITS[self._layout.unit])
        return ns if ns > UNIX else None

    def times(self, rows: Integers) -> tuple[Floats, str]:
        """Return the times [s] of these rows from the first, and a note on a repair."""
        others: dict[str, Floats] = {}
        if self.device is not None:
            others["the device"] = _seconds(self.device[rows], self._layout.device_unit)
        rate = self._layout.rate
        stamps = None if self._stamps is None else _seconds(self._stamps[rows], self._layout.unit)
        if self.sequence is not None and stamps is not None:
            others["the sequence numbers"] = counted(self.sequence[rows].astype(np.float64), stamps)
        if rate is not None:
            others["rate_hz"] = np.arange(rows.size) / rate
        if stamps is None:
            return others["rate_hz"], ""
        return settled(stamps, others, f"stamps of {self._layout.time!r}")


def _seconds(stamps: Any, unit: str) -> Floats:
    """Return stamps as seconds from the first one, exact for whole numbers."""
    finite = np.isfinite(stamps)
    first = stamps[finite][0] if finite.any() else 0
    kept: Floats = (stamps - first) * (UNITS[unit] * 1e-9)
    zero = (stamps == 0) & (first != 0)  # a stamp of zero is none
    return np.where(zero, np.nan, kept) if zero.any() and first > 0 and zero.sum() < stamps.size else kept


def _columns(board: Board, values: Floats, t: Floats, clock: _Clock, rows: Integers) -> dict[str, Any]:
    """Return the columns of a finger for `ColumnFrames`: axes turned, gains applied, chips in their cells."""
    turned = values @ board.turn.T
    if board.gains is not None:
        turned = board.gains(turned)
    turned = np.concatenate([turned, np.full((len(turned), 1, 3), np.nan)], axis=1)  # cell -1
    frames = turned[:, board.cells]
    device = np.full(rows.size, np.nan) if clock.device is None else clock.device[rows].astype(np.float64)
    sequence = np.arange(rows.size) if clock.sequence is None else np.nan_to_num(clock.sequence[rows]).astype(np.int64)
    return {
        "values": frames, "valid": np.isfinite(frames).all(-1), "t_s": t,
        "t_device_s": device * (UNITS[clock._layout.device_unit] * 1e-9), "sequence": sequence,
    }  # fmt: skip


def _joined(takes: list[dict[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([take[name] for take in takes]) for name in takes[0]}


def _place(fingers: list[dict[str, Any]]) -> None:
    """Set the place of every frame: by time, then by finger."""
    t = np.concatenate([one["t_s"] for one in fingers])
    place = np.empty(t.size, np.int64)
    place[np.argsort(t, kind="stable")] = np.arange(t.size)
    for one, mine in zip(fingers, np.split(place, np.cumsum([one["t_s"].size for one in fingers])[:-1]), strict=True):
        one["place"] = mine


def _skipped(table: Table, finger: FingerLayout, columns: dict[str, Any]) -> str:
    """Return a note on readings that are no numbers."""
    count = int((~columns["valid"]).sum()) - int((finger.board.cells < 0).sum()) * len(columns["valid"])
    return f"{finger.board.array.name}: {count} readings of taxels are no numbers in {table.path.name}" if count else ""
