"""Plot of a run: events, normal and shear signals over time, and the taxel plane."""

from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.files import writing
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import HAND, TaxelArray
from tactile.output.collected import Collected, Columns
from tactile.output.plot_labels import label, mark
from tactile.output.plot_plane import SURE, draw_plane
from tactile.thresholds.threshold import CONTACT

TITLE = 100
"""Longest line of the title in characters."""
LEAST = 0.1
"""Least height of an axis over the largest value, so that rounding of a constant is not visible."""
LEAST_FORCE = 0.01
"""[N] Least height of an axis of located loads."""


def draw(collected: Collected, arrays: tuple[TaxelArray, ...], title: str, path: Path) -> None:
    """Write the picture of a run.

    Raises:
        InputError: the file cannot be written.
    """
    figure = picture(collected, arrays, title)
    with writing(path) as beside:
        figure.savefig(beside, dpi=100)


def picture(collected: Collected, arrays: tuple[TaxelArray, ...], title: str) -> Any:
    """Return the figure: for each finger its events, its normal and shear signals over time, and the taxel plane."""
    from matplotlib.figure import Figure  # slow to import

    figure = Figure(figsize=(13, 1 + 4.6 * len(arrays)), layout="constrained")
    figure.suptitle(fill(title, TITLE, max_lines=3, placeholder=" ..."), fontsize=14, parse_math=False)
    labelled = []
    for part, array in zip(figure.subfigures(len(arrays), 1, squeeze=False)[:, 0], arrays, strict=True):
        columns = collected.columns(array.name)
        events = [event for event in collected.events if event.finger in (array.name, HAND)]
        room = 0.2 + 0.1 * min(len(events), 8)
        grid = part.add_gridspec(3, 2, width_ratios=[3.0, 1.1], height_ratios=[room, 1, 1])
        normal = part.add_subplot(grid[1, 0])
        shear = part.add_subplot(grid[2, 0], sharex=normal)
        labels = part.add_subplot(grid[0, 0], sharex=normal)
        labels.axis("off")
        tare = collected.tare(array)
        _signals(normal, shear, columns, array)
        if tare is not None and columns.t.size:
            _tared(normal, shear, columns.t[: tare.frames])
        mark((normal, shear), events)
        labels.set_title(f"{array.name}: {len(events)} events", loc="left")
        others = collected.others(array.name)
        firmest, dead_band = collected.strongest.get(array.name), collected.dead_bands.get(array.name)
        draw_plane(part.add_subplot(grid[:, 1]), columns, array, firmest, others, dead_band)
        labelled.append((labels, events, array.name))
    figure.draw_without_rendering()  # lays out the figure, which the labels need
    figure.set_layout_engine("none")
    for axis, events, name in labelled:
        shown = label(axis, events)
        rest = "" if shown == len(events) else f", {len(events) - shown} without room for a label"
        axis.set_title(f"{name}: {len(events) or 'no'} event{'s' * (len(events) != 1)}{rest}", loc="left")
    return figure


def _signals(normal: Any, shear: Any, columns: Columns, array: TaxelArray) -> None:
    """Draw the components of a located load, or the sums over the taxels."""
    t = columns.t
    located = array.quantity != "force" and np.isfinite((columns.Q, columns.R, columns.F)).any()
    if located:
        pressing, along_x, along_y, unit, what = columns.F, columns.Q, columns.R, "N", "located load"
        least = LEAST_FORCE
    else:
        scale, unit = UNITS[array.quantity]
        inward = scale if array.quantity == "force" else -scale
        pressing, along_x, along_y = inward * columns.normal, scale * columns.shear_x, scale * columns.shear_y
        what, least = "sum of taxels", scale * CONTACT[array.quantity].dead_band
    doubted = np.isfinite(pressing) & ~np.isin(columns.validity, SURE) & located
    _line(normal, t, pressing, doubted, "black", "")
    sheared = bool(
        np.isfinite(along_x).any() or np.isfinite(along_y).any()
    )  # a row locates along one axis only, a column along the other
    if sheared:
        for signal, colour, name in ((along_x, "tab:blue", "x"), (along_y, "tab:orange", "y")):
            _line(shear, t, signal, doubted, colour, name if np.isfinite(signal).any() else f"{name}: not known")
    else:
        words = "one taxel cannot separate shear from position" if located else "no reading" if t.size else "no frame"
        shear.text(0.5, 0.5, words, transform=shear.transAxes, ha="center", va="center", backgroundcolor="white")
    if doubted.any():
        normal.plot([], [], ".", color="0.6", label="uncertain: ambiguous, or no single point load")
        doubts = normal.legend(loc="lower right", bbox_to_anchor=(1, 0.98), fontsize=8, frameon=False)
    if sheared:
        shear.legend(loc="lower right", bbox_to_anchor=(1, 0.98), ncols=2, fontsize=8, frameon=False)
    for axis, signals, which in ((normal, (pressing,), "normal"), (shear, (along_x, along_y), "shear")):
        _heights(axis, _looked_at(np.concatenate(signals), np.tile(doubted, len(signals)), least), least)
        axis.set_ylabel(f"{which} [{unit}]\n{what}")
    shear.set_xlabel("time [s]")
    normal.tick_params(labelbottom=False)
    if doubted.any():
        low, high = normal.get_ylim()
        beyond = int(((pressing[doubted] < low) | (pressing[doubted] > high)).sum())
        if beyond:
            doubts.get_texts()[0].set_text(f"{doubts.get_texts()[0].get_text()}; {beyond} of them beyond the axis")
    if t.size:
        normal.set_xlim(t[0], max(t[-1], t[0] + 1e-3))
    else:
        shear.set_xticks([])


def _looked_at(signal: Floats, doubted: Any, least: float) -> Floats:
    """Return the values that set the limits of the axis: certain ones, and uncertain ones near them."""
    sure = signal[np.isfinite(signal) & ~doubted]
    if not sure.size:
        return signal
    low, high = float(sure.min()), float(sure.max())
    reach = max(high - low, max(abs(low), abs(high)), least)
    near: Floats = signal[(signal >= low - reach) & (signal <= high + reach)]
    return near


def _line(axis: Any, t: Floats, signal: Floats, doubted: Any, colour: str, name: str) -> None:
    """Draw a signal, with pale dots where it is uncertain."""
    sure = np.where(doubted, np.nan, signal)
    axis.plot(t, sure, color=colour, label=name)
    gaps = np.concatenate([[True], ~np.isfinite(sure), [True]])
    alone = ~gaps[1:-1] & gaps[:-2] & gaps[2:]
    if alone.any():  # a line needs two points
        axis.plot(t[alone], sure[alone], ".", color=colour, markersize=5, clip_on=False)
    if doubted.any():
        axis.plot(t[doubted], signal[doubted], ".", color=colour, alpha=0.4, markersize=3, markeredgewidth=0)


def _heights(axis: Any, signal: Floats, least: float) -> None:
    """Set the limits of the axis so that nearly constant values look constant."""
    axis.ticklabel_format(axis="y", useOffset=False)
    known = signal[np.isfinite(signal)]
    if not known.size:
        axis.set_yticks([])
        return
    low, high = float(known.min()), float(known.max())
    span = max(high - low, LEAST * max(abs(low), abs(high)), least)
    middle = (low + high) / 2
    axis.set_ylim(middle - 0.55 * span, middle + 0.55 * span)


def _tared(normal: Any, shear: Any, t: Floats) -> None:
    """Shade the time of the tare, without signals."""
    for axis in (normal, shear):
        axis.axvspan(t[0], t[-1], color="0.93", zorder=-1)
    normal.text(t[0], 0.02, " tare", transform=normal.get_xaxis_transform(), fontsize=8, color="0.4")
