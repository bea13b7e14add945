"""Labels of recordings: what is known to have happened to each finger, read from a CSV file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cnnsim.support import InputError
from tactile.core.label_lines import read_lines

TRUTHS = {
    "contact_s": "contact", "release_s": "release", "tangential_onset_s": "tangential_load", "gross_slip_s": "slip",
}  # fmt: skip
"""Column of a label file -> kind of event that has to begin then."""
HOLD = ("peak_s", "open_s")
"""Columns between which a finger holds; the first half second after the peak is left out: the grip settles."""
SETTLING = 0.5
FLAG = "flag_on_s"
"""Column of the time at which the device itself says contact."""


@dataclass(frozen=True)
class Labelled:
    """One finger of one recording: ``times`` [s] by kind of event, when it ``holds`` [s], the device's ``flag`` [s]."""

    recording: str
    finger: int
    times: Mapping[str, float]
    holds: tuple[float, float] | None
    flag: float | None


def read_labels(path: Path) -> list[Labelled]:
    """Return the lines of a label file: recording, sensor (0, 1, ...) and columns of times [s], empty where none.

    Raises:
        InputError: no such file, a column that is missing, a number that is none.
    """
    lines, columns = read_lines(path)
    missing = {"recording", "sensor"} - set(columns)
    known = [column for column in TRUTHS if column in columns]
    if missing or not known:
        raise InputError(
            f"{path}: columns {', '.join(columns)}; recording, sensor and one of {', '.join(TRUTHS)} wanted"
        )
    labels = []
    for n, line in enumerate(lines, 2):
        try:
            numbers = {name: float(line[name]) for name in (*known, *HOLD, FLAG) if line.get(name)}
            finger = int(line["sensor"])
        except (TypeError, ValueError) as error:  # a TypeError: a line that ends before its sensor
            raise InputError(f"{path}, line {n}: {error}; numbers wanted") from error
        holds = (numbers[HOLD[0]] + SETTLING, numbers[HOLD[1]]) if all(name in numbers for name in HOLD) else None
        times = {TRUTHS[name]: numbers[name] for name in known if name in numbers}
        labels.append(Labelled(line["recording"], finger, times, holds, numbers.get(FLAG)))
    return labels
