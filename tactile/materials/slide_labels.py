"""Labels of slides: material, finger and time interval in recordings, from a CSV file."""

from dataclasses import dataclass
from pathlib import Path

from cnnsim.support import InputError
from tactile.core.label_lines import read_lines

NEEDED = ("recording", "material")
OPTIONAL = ("sensor", "start_s", "stop_s", "speed_mm_s", "block")


@dataclass(frozen=True)
class SlideLabel:
    """One stroke: ``recording`` without suffix, ``material``, ``finger``, ``start``, ``stop`` [s], ``speed`` [m/s].

    ``block``: group of slides recorded together. None for values that the file does not have.
    """

    recording: str
    material: str
    finger: int | None = None
    start: float | None = None
    stop: float | None = None
    speed: float | None = None
    block: int | None = None


def read_slide_labels(path: Path) -> list[SlideLabel]:
    """Return the rows of a label file: columns recording, material and optionally those of `OPTIONAL`.

    Raises:
        InputError: no such file, a missing column, an empty name, an invalid number.
    """
    lines, columns = read_lines(path)
    if not set(NEEDED) <= set(columns):
        raise InputError(f"{path}: columns {', '.join(columns)}; {' and '.join(NEEDED)} wanted")
    labels = []
    for n, line in enumerate(lines, 2):
        if not (line["recording"] and line["material"]):
            raise InputError(f"{path}, line {n}: an empty recording or material; both wanted")
        try:
            sensor, block = (int(line[name]) if line.get(name) else None for name in ("sensor", "block"))
            start, stop, speed = (float(line[name]) if line.get(name) else None for name in OPTIONAL[1:4])
        except ValueError as error:
            raise InputError(f"{path}, line {n}: {error}; numbers wanted") from error
        pace = None if speed is None else speed * 1e-3
        labels.append(SlideLabel(line["recording"], line["material"], sensor, start, stop, pace, block))
    return labels
