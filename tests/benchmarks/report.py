"""The table, its JSON and its picture."""

import json
import platform
from dataclasses import asdict
from pathlib import Path

import matplotlib.pyplot as plt

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


def save(rows: list[Row], fma: float, triad: float, folder: Path) -> None:
    """Write ``benchmarks.json`` and ``benchmarks.png``."""
    folder.mkdir(parents=True, exist_ok=True)
    machine = {
        "processor": platform.machine(),
        "python": platform.python_version(),
        "fma_gflops": fma,
        "triad_gbs": triad,
    }
    (folder / "benchmarks.json").write_text(
        json.dumps({"machine": machine, "rows": [asdict(row) for row in rows]}, indent=1)
    )
    bars = [(f"{row.work}, {row.who}: {name}", ratio) for row in rows for name, ratio in row.ratios.items()]
    figure, axes = plt.subplots(figsize=(9, 1 + 0.28 * len(bars)), layout="constrained")
    axes.barh([name for name, _ in bars][::-1], [ratio for _, ratio in bars][::-1], color="0.35")
    axes.axvline(1, color="tab:red", linewidth=1)
    axes.set(xscale="log", xlabel="times as fast (or share of the limit)")
    figure.savefig(folder / "benchmarks.png", dpi=120)
    plt.close(figure)
