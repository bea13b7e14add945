"""Figure of a run: bars of events, normal and shear signals over time, and the taxel plane of each finger."""

from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from cnnsim.support import Flags, Floats
from cnnsim.support.files import writing
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import HAND, TaxelArray
from tactile.events.event import Event
from tactile.output.collected import Collected, Columns
from tactile.output.plane import SURE, Plane
from tactile.output.plot_events import ROW, draw_events, label_events, rows_of
from tactile.output.plot_plane import draw_planes
from tactile.thresholds.threshold import CONTACT

TITLE = 100
"""Longest line of the title in characters."""
LEAST = 0.1
"""Least height of an axis over the largest value, so that rounding of a constant is not visible."""
LEAST_FORCE = 0.01
"""[N] Least height of an axis of located loads."""
SIGNAL = 1.25
"""[inch] Height of a signal's axis."""
COLOURS = {"x": "#0072b2", "y": "#d55e00"}


@dataclass(frozen=True)
class Signals:
    """Signals of a finger: ``pressing``, ``along_x``, ``along_y`` in ``unit``, ``doubted`` where they are uncertain."""

    t: Floats
    pressing: Floats
    along_x: Floats
    along_y: Floats
    doubted: Flags
    unit: str
    what: str
    least: float

    def limits(self, shear: bool) -> tuple[float, float] | None:
        """Return the smallest and largest value to show of the shear or normal signals, None without any."""
        signal = np.concatenate([self.along_x, self.along_y]) if shear else self.pressing
        known = _looked_at(signal, np.tile(self.doubted, 2 if shear else 1), self.least)
        known = known[np.isfinite(known)]
        return (float(known.min()), float(known.max())) if known.size else None


def draw(collected: Collected, arrays: tuple[TaxelArray, ...], title: str, path: Path) -> None:
    """Write the picture of a run.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import

    figure = Figure()
    draw_run(figure, collected, arrays, title)
    with writing(path) as beside:
        figure.savefig(beside, dpi=100)


def draw_run(figure: Any, collected: Collected, arrays: tuple[TaxelArray, ...], title: str) -> None:
    """Draw into an empty figure for each finger its events, its normal and shear signals, and the taxel plane.

    Axes of signals of one unit have the same limits; planes share their scales of colours and arrows. Events of the
    hand are drawn with the first finger.
    """
    shown = [(array.name, HAND) if array is arrays[0] else (array.name,) for array in arrays]
    happened = [[one for one in collected.events if one.finger in names] for names in shown]
    rows = [rows_of(events, collected.events) for events in happened]
    heights = [ROW * len(of_finger) + 2 * SIGNAL + 1.1 for of_finger in rows]
    figure.set_size_inches(13, sum(heights) + 0.6)
    figure.set_layout_engine("constrained")
    figure.suptitle(fill(title, TITLE, max_lines=3, placeholder=" ..."), fontsize=14, parse_math=False)
    outer = figure.add_gridspec(len(arrays), 2, width_ratios=[3.0, 1.1], height_ratios=heights)
    signals = [_signals(collected.columns(array.name), array) for array in arrays]
    panels, planes, first = [], [], None
    for number, array in enumerate(arrays):
        grid = outer[number, 0].subgridspec(3, 1, height_ratios=[ROW * max(len(rows[number]), 1), SIGNAL, SIGNAL])
        events = figure.add_subplot(grid[0], sharex=first)
        first = first or events
        normal, shear = (figure.add_subplot(grid[place], sharex=first) for place in (1, 2))
        _draw_signals(normal, shear, signals[number])
        if (tare := collected.tare(array)) is not None and signals[number].t.size:
            _tared(normal, shear, signals[number].t[: tare.frames])
        events.set_title(_counted(array.name, happened[number]), loc="left", parse_math=False)
        draw_events(events, happened[number], rows[number], _end(signals))
        panels.append((events, normal, shear))
        others = collected.others(array.name)
        firmest, dead_band = collected.strongest.get(array.name), collected.dead_bands.get(array.name)
        axis = figure.add_subplot(outer[number, 1])
        planes.append(Plane(axis, array, collected.columns(array.name), firmest, others, dead_band))
    _same_limits(panels, signals)
    draw_planes(figure, planes)
    if (end := _end(signals)) > (start := min((one.t[0] for one in signals if one.t.size), default=end)):
        panels[0][0].set_xlim(start, end)
    figure.draw_without_rendering()  # lays out the figure, which the texts need
    figure.set_layout_engine("none")
    for (axis, *_), events_of, rows_of_finger in zip(panels, happened, rows, strict=True):
        label_events(axis, events_of, rows_of_finger)


def _counted(name: str, events: list[Event]) -> str:
    """Return the title of a finger: the numbers of its events and of those of the hand."""
    counts = sum(event.finger != HAND for event in events), sum(event.finger == HAND for event in events)
    own, hand = (f"{count or 'no'} event{'s' * (count != 1)}" for count in counts)
    return f"{name}: {own}" + (f", {hand} of the hand" if counts[1] else "")


def _end(signals: list[Signals]) -> float:
    return max((float(one.t[-1]) for one in signals if one.t.size), default=0.0)


def _signals(columns: Columns, array: TaxelArray) -> Signals:
    """Return the components of the located load, or the sums over the taxels."""
    if array.quantity != "force" and np.isfinite((columns.Q, columns.R, columns.F)).any():
        doubted = np.isfinite(columns.F) & ~np.isin(columns.validity, SURE)
        return Signals(columns.t, columns.F, columns.Q, columns.R, doubted, "N", "located load", LEAST_FORCE)
    scale, unit = UNITS[array.quantity]
    inward = scale if array.quantity == "force" else -scale
    along = inward * columns.normal, scale * columns.shear_x, scale * columns.shear_y
    least = scale * CONTACT[array.quantity].dead_band
    return Signals(columns.t, *along, np.zeros(columns.t.shape, bool), unit, "sum of taxels", least)


def _draw_signals(normal: Any, shear: Any, one: Signals) -> None:
    _line(normal, one.t, one.pressing, one.doubted, "black", "")
    for signal, name in ((one.along_x, "x"), (one.along_y, "y")):
        known = np.isfinite(
            signal
        ).any()  # a row locates along one axis only, a column along the other, a taxel neither
        _line(shear, one.t, signal, one.doubted, COLOURS[name], name if known else f"{name}: not known")
    if one.doubted.any():
        normal.plot([], [], ".", color="0.6", label="uncertain: ambiguous, or no single point load")
        normal.legend(loc="lower right", bbox_to_anchor=(1, 0.98), fontsize=8, frameon=False)
    shear.legend(loc="lower right", bbox_to_anchor=(1, 0.98), ncols=2, fontsize=8, frameon=False)
    normal.set_ylabel(f"normal [{one.unit}]\n{one.what}")
    shear.set_ylabel(f"shear [{one.unit}]\n{one.what}")
    shear.set_xlabel("time [s]")
    normal.tick_params(labelbottom=False)
    if not one.t.size:
        shear.set_xticks([])


def _same_limits(panels: list[tuple[Any, Any, Any]], signals: list[Signals]) -> None:
    """Set equal limits of all axes of the same unit and direction, so that nearly constant values look constant."""
    for shear in (False, True):
        for unit in {one.unit for one in signals}:
            chosen = [(panel[1 + shear], one) for panel, one in zip(panels, signals, strict=True) if one.unit == unit]
            found = [limits for _, one in chosen if (limits := one.limits(shear)) is not None]
            for axis, one in chosen:
                axis.ticklabel_format(axis="y", useOffset=False)
                if not found:
                    axis.set_yticks([])
                    continue
                low, high = min(limits[0] for limits in found), max(limits[1] for limits in found)
                span = max(high - low, LEAST * max(abs(low), abs(high)), one.least)
                axis.set_ylim((low + high) / 2 - 0.55 * span, (low + high) / 2 + 0.55 * span)
                if not shear and one.doubted.any():
                    _count_beyond(axis, one.pressing[one.doubted])


def _count_beyond(axis: Any, doubted: Floats) -> None:
    """Add the number of uncertain values beyond the axis to the legend."""
    low, high = axis.get_ylim()
    beyond = int(((doubted < low) | (doubted > high)).sum())
    if beyond:
        text = axis.get_legend().get_texts()[0]
        text.set_text(f"{text.get_text()}; {beyond} of them beyond the axis")


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


def _tared(normal: Any, shear: Any, t: Floats) -> None:
    """Shade the time of the tare, without signals."""
    for axis in (normal, shear):
        axis.axvspan(t[0], t[-1], color="0.93", zorder=-1, label="tare")
    handles, names = normal.get_legend_handles_labels()
    normal.legend(handles, names, loc="lower right", bbox_to_anchor=(1, 0.98), ncols=2, fontsize=8, frameon=False)
