"""Labels of recordings: known times of events of each finger, from a CSV file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Self

from cnnsim.support import InputError
from tactile.core.label_lines import read_lines
from tactile.core.source import Source, with_frames

TRUTHS = {
    "contact_s": "contact", "release_s": "release", "tangential_onset_s": "tangential_load", "gross_slip_s": "slip",
}  # fmt: skip
"""Column of a label file -> kind of the event that begins then."""
HOLD = ("peak_s", "open_s")
"""Columns that bound a hold; the first half second after the peak is excluded, because the grip settles."""
SETTLING = 0.5
FLAG = "flag_on_s"
"""Column of the time of the device's own contact flag."""


@dataclass(frozen=True)
class Labelled:
    """A finger of a recording: ``times`` [s] by kind, hold interval ``holds`` [s], ``flag`` [s] of the device."""

    recording: str
    finger: int
    times: Mapping[str, float]
    holds: tuple[float, float] | None
    flag: float | None


@dataclass(frozen=True)
class LabelledSource:
    """A recording or a simulated grasp: its ``source`` and the labels of its fingers."""

    name: str
    source: Source
    labels: Sequence[Labelled]

    def in_memory(self) -> Self:
        """Return it with all its frames read."""
        return replace(self, source=with_frames(self.source, list(self.source)))


def read_labels(path: Path, kind: str | None = None) -> list[Labelled]:
    """Return the rows of a label file: recording, sensor (0, 1, ...) and columns of times [s], empty if unknown.

    The times of another ``kind`` of event are in a column of its name and ``_s``.

    Raises:
        InputError: no such file, a missing column, an invalid number.
    """
    lines, columns = read_lines(path)
    truths = TRUTHS if kind is None or kind in TRUTHS.values() else {**TRUTHS, f"{kind}_s": kind}
    missing = {"recording", "sensor"} - set(columns)
    known = [column for column in truths if column in columns]
    if missing or not known:
        raise InputError(
            f"{path}: columns {', '.join(columns)}; recording, sensor and one of {', '.join(truths)} wanted"
        )
    labels = []
    for n, line in enumerate(lines, 2):
        try:
            numbers = {name: float(line[name]) for name in (*known, *HOLD, FLAG) if line.get(name)}
            finger = int(line["sensor"])
        except (TypeError, ValueError) as error:  # TypeError: an incomplete line
            raise InputError(f"{path}, line {n}: {error}; numbers wanted") from error
        if wrong := [f"{name} = {one}" for name, one in numbers.items() if not isfinite(one)]:
            raise InputError(f"{path}, line {n}: {', '.join(wrong)}; finite times wanted")
        holds = (numbers[HOLD[0]] + SETTLING, numbers[HOLD[1]]) if all(name in numbers for name in HOLD) else None
        times = {truths[name]: numbers[name] for name in known if name in numbers}
        labels.append(Labelled(line["recording"], finger, times, holds, numbers.get(FLAG)))
    return labels
