"""Plot of a run, one picture: the events, the normal and shear signals over time, and where the load was."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim import InputError
from cnnsim.support import Floats
from tactile.core.frame import NORMAL, TaxelArray
from tactile.events.contact_and_shear import TouchKind
from tactile.events.event import Event, EventKind
from tactile.events.slip import SlipKind
from tactile.events.tangential_load import LoadKind
from tactile.output.collected import Collected, Columns
from tactile.output.tables import grouped

UNIT = {"force": (1.0, "N"), "strain": (1e3, "‰"), "stress": (1e-3, "kPa")}
COLOURS: dict[EventKind, str] = {
    TouchKind.CONTACT: "tab:green",
    TouchKind.CONTACT_CHANGES: "tab:green",
    TouchKind.RELEASE: "tab:red",
    **dict.fromkeys(SlipKind, "tab:purple"),
    **dict.fromkeys(LoadKind, "tab:orange"),
}
"""Colours of the important kinds of event; the others are grey."""
APART = 0.022
"""Labels closer than this part of the time axis would lie on each other; the less important one is left out."""


def draw(collected: Collected, arrays: tuple[TaxelArray, ...], title: str, path: Path) -> None:
    """Write the picture: for each finger its events, its normal and shear signals over time, and the taxel plane.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import

    figure = Figure(figsize=(13, 1 + 4.6 * len(arrays)), layout="constrained")
    figure.suptitle(title, fontsize=14)
    for part, array in zip(figure.subfigures(len(arrays), 1, squeeze=False)[:, 0], arrays, strict=True):
        grid = part.add_gridspec(3, 3, width_ratios=[3.0, 0.2, 1], height_ratios=[1.1, 1, 1])  # room for labels
        columns = collected.columns(array.name)
        events = [event for event in collected.events if event.finger == array.name]
        normal = part.add_subplot(grid[1, 0])
        shear = part.add_subplot(grid[2, 0], sharex=normal)
        labels = part.add_subplot(grid[0, 0], sharex=normal)
        _signals(normal, shear, columns, array)
        _events(labels, (normal, shear), events, columns.t)
        labels.set_title(f"{array.name}: {len(events)} events", loc="left")
        _plane(part.add_subplot(grid[:, 2]), columns, array, collected.strongest.get(array.name))
    try:
        figure.savefig(path, dpi=100)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error


def _signals(normal: Any, shear: Any, columns: Columns, array: TaxelArray) -> None:
    """Draw the load's components where it was located, else the taxels' sums."""
    t = columns.t
    if np.isfinite((columns.Q, columns.R, columns.F)).any():
        pressing, along_x, along_y, unit, what = columns.F, columns.Q, columns.R, "N", "located load"
    else:
        scale, unit = UNIT[array.quantity]
        inward = scale if array.quantity == "force" else -scale
        pressing, along_x, along_y = inward * columns.normal, scale * columns.shear_x, scale * columns.shear_y
        what = "sum of taxels"
    normal.plot(t, pressing, color="black")
    normal.set_ylabel(f"normal [{unit}]\n{what}")
    if np.isfinite(along_x).any():
        shear.plot(t, along_x, color="tab:blue", label="x")
        shear.plot(t, along_y, color="tab:orange", label="y")
        shear.legend(loc="upper right", ncols=2, fontsize=8)
    else:
        shear.set_yticks([])
        words = "one taxel alone cannot tell shear from place"
        shear.text(0.5, 0.5, words, transform=shear.transAxes, ha="center", va="center", backgroundcolor="white")
    shear.set_ylabel(f"shear [{unit}]\n{what}")
    shear.set_xlabel("time [s]")
    normal.tick_params(labelbottom=False)
    if t.size:
        normal.set_xlim(t[0], max(t[-1], t[0] + 1e-3))


def _events(labels: Any, signals: tuple[Any, ...], events: list[Event], t: Floats) -> None:
    """Mark every event on the signals, and write down as many as can be read: the important ones first."""
    for event in events:
        colour = COLOURS.get(event.kind, "0.75")
        for axis in signals:
            axis.axvline(event.t, color=colour, linewidth=0.7, zorder=0)
    span = float(np.ptp(t)) if t.size else 1.0
    taken: list[float] = []
    for event, changes in sorted(grouped(events), key=lambda line: line[0].kind not in COLOURS):
        if any(abs(event.t - other) < APART * span for other in taken):
            continue
        taken.append(event.t)
        text = event.words if changes == 1 else f"{event.words} ({changes}x)"
        colour = COLOURS.get(event.kind, "0.4")
        place = {"xycoords": ("data", "axes fraction"), "rotation": 35, "va": "bottom", "annotation_clip": False}
        labels.annotate(text, (event.t, 0.0), fontsize=8, color=colour, **place).set_in_layout(False)
    labels.set_ylim(0, 1)
    labels.axis("off")


def _plane(axis: Any, columns: Columns, array: TaxelArray, strongest: Floats | None) -> None:
    """Draw the taxels, and over them the track of the located load, or the forces of the firmest moment."""
    places = array.positions().reshape(-1, 2) * 1e3
    axis.scatter(*places.T, marker="s", s=110, facecolor="none", edgecolor="gray")
    located = np.isfinite(columns.x)
    if located.any():
        t, x, y, force = (column[located] for column in (columns.t, columns.x, columns.y, columns.F))
        press = np.where(np.isfinite(force), force, 0.0)
        size = 6 + 60 * np.clip(press / max(press.max(), 1e-12), 0, 1)
        dots = axis.scatter(x * 1e3, y * 1e3, c=t, s=size, cmap="viridis", linewidth=0)
        axis.figure.colorbar(dots, ax=axis, label="time [s]", location="bottom", shrink=0.8)
    words = "located load, larger where firmer"
    if array.quantity == "force" and strongest is not None:
        words = "firmest moment: grey normal, blue shear"
        press = np.clip(strongest[..., NORMAL].ravel(), 0, None)
        axis.scatter(*places.T, s=900 * press / max(press.max(), 1e-12), color="0.85", zorder=0)
        shear = strongest[..., :NORMAL].reshape(-1, 2)
        longest = max(np.hypot(*shear.T).max(), 1e-12) / (0.7e3 * array.pitch)
        axis.quiver(*places.T, *shear.T, angles="xy", scale_units="xy", scale=longest, color="tab:blue", width=0.012)
    axis.set_title(f"taxels seen from outside\n{words}", loc="left", fontsize=9)
    axis.set_aspect("equal", adjustable="box")
    half = max(np.ptp(places[:, 0]), np.ptp(places[:, 1]), array.pitch * 1e3) * 0.8
    centre = places.mean(axis=0)
    axis.set_xlim(centre[0] - half, centre[0] + half)
    axis.set_ylim(centre[1] + half, centre[1] - half)
    axis.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")
