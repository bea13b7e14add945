"""Taxel planes of a run: positions of the load, or the strongest frame, on shared scales of colours and arrows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import NORMAL
from tactile.output.plane import SQUARES, SURE, Plane, blocks, round_number
from tactile.thresholds.threshold import CONTACT, SHEAR

ARROW = "#0072b2"
"""Colour of the arrows."""
REACH = 0.85
"""Length of the longest arrow over the distance of neighbouring arrows."""


def draw_planes(figure: Any, planes: Sequence[Plane]) -> None:
    """Draw the planes of all fingers with one colour bar for each quantity and one key of arrows."""
    words: list[list[str]] = [[] for _ in planes]
    for plane in planes:
        _frame(plane)
    for quantity in dict.fromkeys(plane.array.quantity for plane in planes if plane.is_map):
        _maps(figure, [plane for plane in planes if plane.is_map and plane.array.quantity == quantity])
    arrows = [plane for plane in planes if plane.is_map and plane.is_force]
    if arrows:
        _arrows(arrows)
    located = [plane for plane in planes if not plane.is_force and plane.strongest is not None]
    if located:
        _tracks(figure, located)
    for plane, said in zip(planes, words, strict=True):
        if plane.strongest is None:
            said.append("no frame with a valid reading" if plane.columns.t.size else "no frame")
        if plane.is_map:
            said.append(_map_words(plane))
        if plane in located:
            said += _track_words(plane)
        rows = "\n".join([f"{plane.array.rows} x {plane.array.cols} taxels seen from outside", *said])
        plane.axis.set_title(rows, loc="left", fontsize=9, pad=18 if plane in arrows[:1] else 6)


def _frame(plane: Plane) -> None:
    """Set the limits, and draw the square of each taxel or the outline of a map."""
    from matplotlib.collections import PatchCollection  # slow to import
    from matplotlib.patches import Rectangle  # the same

    axis, array, places = plane.axis, plane.array, plane.array.positions() * 1e3
    axis.set_aspect("equal", adjustable="box")
    x, y = places.reshape(-1, 2).mean(axis=0)
    axis.set_xlim(x - plane.half, x + plane.half)
    axis.set_ylim(y + plane.half, y - plane.half)
    axis.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")
    pitch = array.pitch * 1e3
    if max(array.shape) > SQUARES:
        width, height = array.cols * pitch, array.rows * pitch
        axis.add_patch(Rectangle((x - width / 2, y - height / 2), width, height, fill=False, edgecolor="gray"))
        return
    side = 0.5 * pitch
    squares = [Rectangle((cx - side / 2, cy - side / 2), side, side) for cx, cy in places.reshape(-1, 2)]
    axis.add_collection(PatchCollection(squares, facecolor="none", edgecolor="0.6", linewidth=0.8))


def _maps(figure: Any, planes: Sequence[Plane]) -> None:
    """Draw the normal signals of the strongest frames as grey levels, pulls in red, on one scale."""
    quantity = planes[0].array.quantity
    scale, unit = UNITS[quantity]
    least = scale * CONTACT[quantity].dead_band
    most = max(least, *(float(np.nanmax(np.abs(plane.normal))) for plane in planes))
    pulls = any(np.nanmin(plane.normal) < -least for plane in planes)
    shades: dict[str, Any] = {"cmap": "RdGy", "vmin": -most} if pulls else {"cmap": "Greys", "vmin": 0}
    for plane in planes:
        (x, y), pitch = plane.array.positions()[0, 0] * 1e3, plane.array.pitch * 1e3
        left, top = x - pitch / 2, y - pitch / 2
        edges = left, left + plane.array.cols * pitch, top + plane.array.rows * pitch, top
        top_value = most if pulls else 1.6 * most  # arrows stay visible on the darkest taxel
        image = plane.axis.imshow(
            plane.normal, extent=edges, vmax=top_value, zorder=0, interpolation="nearest", **shades
        )
        unknown = plane.array.positions()[np.isnan(plane.normal)] * 1e3
        plane.axis.plot(*unknown.T, "x", color="0.6", markersize=4)
    bar = _colour_bar(figure, image, planes, f"normal [{unit}], strongest frame")
    bar.ax.set_ylim(-most if pulls else 0, most)


def _colour_bar(figure: Any, image: Any, planes: Sequence[Plane], label: str) -> Any:
    return figure.colorbar(image, ax=[plane.axis for plane in planes], label=label, shrink=0.6, format="%g", aspect=30)


def _arrows(planes: Sequence[Plane]) -> None:
    """Draw shear forces as arrows on one scale [N per width of the axes], and its key above the first plane."""
    shears = [blocks(plane.strongest[..., :NORMAL], plane.block) for plane in planes if plane.strongest is not None]
    least = max(plane.dead_band or SHEAR["force"].dead_band for plane in planes)
    largest = max(float(np.nanmax(np.hypot(*np.moveaxis(shear, -1, 0)))) for shear in shears)
    room = min(plane.array.pitch * 1e3 * plane.block / (2 * plane.half) for plane in planes)
    scale = max(largest, least) / (REACH * room)
    for plane, shear in zip(planes, shears, strict=True):
        at = blocks(plane.array.positions() * 1e3, plane.block)
        arrows = plane.axis.quiver(
            at[..., 0], at[..., 1], shear[..., 0], -shear[..., 1], scale_units="width", scale=scale, units="width",
            color=ARROW, width=0.08 * room, headwidth=3, minlength=0.5,
        )  # fmt: skip
        if plane is planes[0]:
            key = round_number(max(largest, least))
            where = {"labelpos": "W", "coordinates": "axes", "color": ARROW}
            plane.axis.quiverkey(arrows, 0.98 - key / scale, 1.03, key, f"shear {key:g} N", **where)


def _tracks(figure: Any, planes: Sequence[Plane]) -> None:
    """Draw the positions of the loads, coloured by time; dots of all fingers have one scale of sizes."""
    found = [plane.loads() for plane in planes]
    times = np.concatenate([t for t, *_ in found])
    most = max(float(np.concatenate([force for *_, force in found]).max(initial=0.0)), 1e-12)
    dots = None
    for plane, (t, x, y, force) in zip(planes, found, strict=True):
        doubted = np.isfinite(plane.columns.x) & ~np.isin(plane.columns.validity, SURE)
        crosses = plane.columns.x[doubted] * 1e3, plane.columns.y[doubted] * 1e3
        plane.axis.scatter(*crosses, marker="x", s=10, color="0.7", linewidth=0.6, zorder=1)
        if t.size:
            dots = plane.axis.scatter(
                x, y, c=t, s=6 + 60 * force / most, cmap="viridis", linewidth=0, zorder=2, vmin=times.min(),
                vmax=times.max(),
            )  # fmt: skip
    if dots is not None:
        bar = _colour_bar(figure, dots, planes, f"time [s]; largest dot {most:.2g} N")
        if np.ptp(times) == 0:  # limits the scale to times with a located load
            bar.set_ticks([times[0]])


def _map_words(plane: Plane) -> str:
    """Describe the strongest frame of a plane."""
    assert plane.strongest is not None
    unit = UNITS[plane.array.quantity][1]
    words = [f"strongest frame: normal {np.nansum(plane.normal):.3g} {unit}"]
    if plane.is_force:
        shear = np.hypot(*np.moveaxis(blocks(plane.strongest[..., :NORMAL], plane.block), -1, 0))
        largest, dead_band = float(np.nanmax(shear)), plane.dead_band or SHEAR["force"].dead_band
        what = f"means of {plane.block} x {plane.block} taxels" if plane.block > 1 else "shear of each taxel"
        words.append(f"arrows: {what}\nat most {largest:.2g} N{', below the dead band' * (largest < dead_band)}")
    if unknown := int(np.isnan(plane.normal).sum()):
        words.append(f"crosses: no reading, {unknown} taxel{'s' * (unknown > 1)}")
    return "\n".join(words)


def _track_words(plane: Plane) -> list[str]:
    """Describe the positions of the loads of a plane."""
    t, x, y, _ = plane.loads()
    doubted = np.isfinite(plane.columns.x) & ~np.isin(plane.columns.validity, SURE)
    words = []
    if t.size:
        frames = len(np.unique(plane.others[np.isin(plane.others[:, 0], t), 0]))
        words += ["located load", *([f"several at once in {frames} frame{'s' * (frames != 1)}"] if frames else [])]
        beyond = _beyond(plane.axis, x, y)
        words += [f"{beyond} dot{'s' * (beyond != 1)} beyond the edge"] if beyond else []
    if count := int(doubted.sum()):
        beyond = _beyond(plane.axis, plane.columns.x[doubted] * 1e3, plane.columns.y[doubted] * 1e3)
        edge = f", {beyond} beyond the edge" if beyond else ""
        words.append(f"crosses: uncertain, {count} frame{'s' * (count != 1)}{edge}")
    return words or ["no load located"]


def _beyond(axis: Any, x: Floats, y: Floats) -> int:
    """Count the positions [mm] outside the axis."""
    (left, right), (low, high) = axis.get_xlim(), sorted(axis.get_ylim())
    return int(((x < left) | (x > right) | (y < low) | (y > high)).sum())
