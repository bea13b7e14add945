"""One picture of a run that a person understands at sight: forces over time, event marks, and where the load was."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim import InputError
from tactile.frame import TaxelArray
from tactile.sinks import Collected

UNIT = {"force": "N", "strain": "‰", "stress": "kPa"}
SCALE = {"force": 1.0, "strain": 1e3, "stress": 1e-3}
MARKS = {"contact": "tab:green", "release": "tab:red", "slip": "tab:purple"}
MAX_LABELS = 14
"""More event labels than this on one axis cannot be read; the marks stay."""


def draw(collected: Collected, arrays: tuple[TaxelArray, ...], title: str, path: Path) -> None:
    """Write the picture: a row a finger, time on the left, the taxel plane on the right.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import

    figure = Figure(figsize=(13, 1 + 3.6 * len(arrays)), layout="constrained")
    axes = figure.subplots(len(arrays), 2, squeeze=False, width_ratios=[3, 1])
    for (timeline, plane), array in zip(axes, arrays, strict=True):
        rows = collected.table(array.name)
        _timeline(timeline, rows, array, [event for event in collected.events if event.finger == array.name])
        _plane(plane, rows, array)
    axes[-1][0].set_xlabel("time [s]")
    figure.suptitle(title)
    try:
        figure.savefig(path, dpi=110)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error


def _timeline(axis: Any, rows: np.ndarray, array: TaxelArray, events: list[Any]) -> None:
    t, scale, unit = rows[:, 0], SCALE[array.quantity], UNIT[array.quantity]
    pressing = 1 if array.quantity == "force" else -1
    located = np.isfinite(rows[:, 6])
    if located.any():
        axis.plot(t, np.where(located, rows[:, 8], np.nan), color="black", label="normal force F [N]")
        axis.plot(t, np.where(located, rows[:, 6], np.nan), color="tab:blue", label="shear Q along x [N]")
        axis.plot(t, np.where(located, rows[:, 7], np.nan), color="tab:orange", label="shear R along y [N]")
        axis.set_ylabel("located load [N]")
    else:
        axis.plot(t, pressing * scale * rows[:, 3], color="black", label=f"normal [{unit}]")
        axis.plot(t, scale * rows[:, 1], color="tab:blue", label=f"shear x [{unit}]")
        axis.plot(t, scale * rows[:, 2], color="tab:orange", label=f"shear y [{unit}]")
        axis.set_ylabel(f"sum of {array.rows * array.cols} taxels [{unit}]")
    axis.margins(x=0.01)
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.75 * (high - low))  # room for the labels of the events
    named = {event.t: event.meaning for event in events}
    labelled = (
        events if len(events) <= MAX_LABELS else [e for e in events if e.meaning.split()[0] in MARKS][:MAX_LABELS]
    )
    for t_event, text in named.items():
        colour = MARKS.get(text.split()[0], "tab:gray")
        axis.axvline(t_event, color=colour, linewidth=0.8, alpha=0.6)
    last = -np.inf
    span = max(float(t[-1] - t[0]), 1e-9) if t.size else 1.0
    for event in labelled:
        if event.t - last < span / 45:
            continue  # it would lie on the label before
        last = event.t
        axis.annotate(
            event.meaning, (event.t, 0.99), xycoords=("data", "axes fraction"), rotation=90, fontsize=7, va="top",
            ha="right", color=MARKS.get(event.meaning.split()[0], "dimgray"),
        )  # fmt: skip
    axis.set_title(f"{array.name}: {len(events)} events", loc="left")
    axis.legend(loc="lower right", fontsize=8, ncols=3)


def _plane(axis: Any, rows: np.ndarray, array: TaxelArray) -> None:
    places = array.positions().reshape(-1, 2) * 1e3
    axis.scatter(*places.T, marker="s", s=120, facecolor="none", edgecolor="gray", label="taxels")
    located = np.isfinite(rows[:, 6])
    if located.any():
        size = 6 + 60 * np.clip(rows[located, 8] / max(rows[located, 8].max(), 1e-12), 0, 1)
        dots = axis.scatter(
            rows[located, 4] * 1e3, rows[located, 5] * 1e3, c=rows[located, 0], s=size, cmap="viridis", linewidth=0
        )
        axis.figure.colorbar(dots, ax=axis, label="time [s]")
        axis.set_title("located load (size: F)", loc="left", fontsize=10)
    else:
        axis.set_title("taxels; force is measured", loc="left", fontsize=10)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.25)
    axis.invert_yaxis()
    axis.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm], down as in CONVENTIONS")
