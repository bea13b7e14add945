"""The table of measurements, and its JSON."""

import json
import platform
from dataclasses import asdict
from pathlib import Path

from tests.benchmarks.race import Row


def table(rows: list[Row]) -> str:
    """Return the rows as text."""
    lines = [("work", "backend", "figure", "to reach", "ratios", "")]
    for row in rows:
        ratios = ", ".join(f"{ratio:.3g} x {name}" for name, ratio in row.ratios.items())
        lines.append((row.work, row.who, f"{row.value:.3g} {row.unit}", row.target, ratios, row.note))
    widths = [max(len(line[i]) for line in lines) for i in range(6)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def save(rows: list[Row], triad: float, folder: Path) -> None:
    """Write ``benchmarks.json``."""
    folder.mkdir(parents=True, exist_ok=True)
    machine = {
        "processor": platform.machine(),
        "python": platform.python_version(),
        "triad_gbs": triad,
    }
    (folder / "benchmarks.json").write_text(
        json.dumps({"machine": machine, "rows": [asdict(row) for row in rows]}, indent=1)
    )
