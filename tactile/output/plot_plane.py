"""Plot of the taxel plane: positions of the load, or the forces of the strongest frame, with scales."""

from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL, TaxelArray
from tactile.inverse.validity import Validity
from tactile.output.collected import Columns
from tactile.thresholds.threshold import SHEAR

SURE = (Validity.INSIDE, Validity.OUTSIDE)
"""Validities of certain positions; others are marked as uncertain."""
SQUARES = 20
"""Largest number of taxels per side that are drawn one by one."""
ARROWS = 16
"""Largest number of arrows per side; larger arrays show means of blocks."""
REACH = 0.85
"""Length of the longest arrow over the distance of neighbouring arrows."""


def draw_plane(
    axis: Any, columns: Columns, array: TaxelArray, strongest: Floats | None, others: Floats, dead_band: float | None
) -> None:
    """Draw the taxels with the tracks of located loads, or with the forces of the strongest frame.

    ``others`` (n, 4): t, x, y, F of further loads; ``dead_band`` [N] of the median taxel's shear in that frame.
    """
    places = array.positions() * 1e3
    _frame(axis, places, array)
    _taxels(axis, array)
    if strongest is None:
        words = "no frame" if not columns.t.size else "no frame with a valid reading"
    elif array.quantity == "force":
        words = _forces(axis, array, places, strongest, dead_band)
    else:
        words = _track(axis, columns, others)
    axis.set_title(f"{array.rows} x {array.cols} taxels seen from outside\n{words}", loc="left", fontsize=9)
    axis.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")


def _frame(axis: Any, places: Floats, array: TaxelArray) -> None:
    axis.set_aspect("equal", adjustable="box")
    margin = 1e3 * max(array.pitch, 1.2 * array.depth)
    half = max(np.ptp(places[..., 0]), np.ptp(places[..., 1])) / 2 + margin
    x, y = places.reshape(-1, 2).mean(axis=0)
    axis.set_xlim(x - half, x + half)
    axis.set_ylim(y + half, y - half)


def _taxels(axis: Any, array: TaxelArray) -> None:
    """Draw the square of each taxel, or the outline of a large array."""
    from matplotlib.collections import PatchCollection  # slow to import
    from matplotlib.patches import Rectangle  # the same

    pitch, (x, y) = array.pitch * 1e3, (at * 1e3 for at in array.origin)
    if max(array.shape) > SQUARES:
        width, height = array.cols * pitch, array.rows * pitch
        axis.add_patch(Rectangle((x - width / 2, y - height / 2), width, height, fill=False, edgecolor="gray"))
        return
    side = 0.5 * pitch
    squares = [
        Rectangle((cx - side / 2, cy - side / 2), side, side) for cx, cy in array.positions().reshape(-1, 2) * 1e3
    ]
    axis.add_collection(PatchCollection(squares, facecolor="none", edgecolor="0.6", linewidth=0.8))


def _track(axis: Any, columns: Columns, others: Floats) -> str:
    """Draw the positions of the loads over time, uncertain ones separately."""
    placed = np.isfinite(columns.x)
    sure = placed & np.isin(columns.validity, SURE)
    doubted = placed & ~sure
    words = []
    if doubted.any():
        axis.scatter(
            columns.x[doubted] * 1e3, columns.y[doubted] * 1e3, marker="x", s=10, color="0.7", linewidth=0.6, zorder=1
        )
        beyond = _beyond(axis, columns.x[doubted] * 1e3, columns.y[doubted] * 1e3)
        count = int(doubted.sum())
        edge = f", {beyond} beyond the edge" if beyond else ""
        words.append(f"crosses: uncertain, {count} frame{'s' * (count != 1)}{edge}")
    if sure.any():
        strongest = (column[sure] for column in (columns.t, columns.x, columns.y, columns.F))
        several = np.isin(others[:, 0], columns.t[sure])
        t, x, y, force = (np.concatenate(both) for both in zip(strongest, others[several].T, strict=True))
        press = np.where(np.isfinite(force), np.abs(force), 0.0)
        most = max(float(press.max()), 1e-12)
        dots = axis.scatter(x * 1e3, y * 1e3, c=t, s=6 + 60 * press / most, cmap="viridis", linewidth=0, zorder=2)
        bar = axis.figure.colorbar(dots, ax=axis, label="time [s]", shrink=0.6, format="%g")
        if np.ptp(t) == 0:  # limits the scale to times with a located load
            bar.set_ticks([t[0]])
        words.insert(0, f"located load, largest dot {most:.2g} N")
        if several.any():
            frames = len(np.unique(others[several, 0]))
            words.append(f"several at once in {frames} frame{'s' * (frames != 1)}")
        beyond = _beyond(axis, x * 1e3, y * 1e3)
        words += [f"{beyond} dot{'s' * (beyond != 1)} beyond the edge"] if beyond else []
    return "\n".join(words) or "no load located"


def _beyond(axis: Any, x: Floats, y: Floats) -> int:
    """Count the positions [mm] outside the axis."""
    (left, right), (low, high) = axis.get_xlim(), sorted(axis.get_ylim())
    return int(((x < left) | (x > right) | (y < low) | (y > high)).sum())


def _forces(axis: Any, array: TaxelArray, places: Floats, values: Floats, dead_band: float | None) -> str:
    """Draw normal forces as grey levels and shear forces as arrows, with scales."""
    pitch, dead_band = array.pitch * 1e3, dead_band or SHEAR["force"].dead_band
    press = values[..., NORMAL]
    most = max(float(np.nanmax(np.abs(press))), dead_band)
    corner = places[0, 0] - pitch / 2
    edges = corner[0], corner[0] + array.cols * pitch, corner[1] + array.rows * pitch, corner[1]
    pulls = np.nanmin(press) < -dead_band
    shades: dict[str, Any] = {"cmap": "RdGy", "vmin": -most, "vmax": most} if pulls else {"cmap": "Greys", "vmin": 0}
    image = axis.imshow(press, extent=edges, **({"vmax": 1.6 * most} | shades), zorder=0, interpolation="nearest")
    axis.figure.colorbar(image, ax=axis, label="normal [N]", shrink=0.6)
    block = -(-max(array.shape) // ARROWS)
    at, shear = _blocks(places, block), _blocks(values[..., :NORMAL], block)
    length = np.hypot(*np.moveaxis(shear, -1, 0))
    largest = float(np.nanmax(length))
    key = round_number(max(largest, dead_band))
    scale = key / (REACH * pitch * block) * max(1.0, largest / key)
    arrows = axis.quiver(
        at[..., 0], at[..., 1], shear[..., 0], shear[..., 1], angles="xy", scale_units="xy", scale=scale,
        color="tab:blue", width=0.08 * pitch * block, units="xy", headwidth=3, minlength=0.5,
    )  # fmt: skip
    left, right = axis.get_xlim()
    start = 0.98 - key / scale / (right - left)
    axis.quiverkey(arrows, start, 1.03, key, f"shear {key:g} N", labelpos="W", coordinates="axes", color="tab:blue")
    what = f"arrows: means of {block} x {block} taxels" if block > 1 else "arrows: shear of each taxel"
    small = ", below the dead band" if largest < dead_band else ""
    unknown = places[np.isnan(press)]
    if len(unknown):
        axis.plot(*unknown.T, "x", color="0.6", markersize=4)
        what += f"\ncrosses: no reading, {len(unknown)} taxel{'s' * (len(unknown) > 1)}"
    return f"strongest frame, {np.nansum(press):.3g} N\n{what}\nat most {largest:.2g} N{small}\n"


def _blocks(plane: Floats, block: int) -> Floats:
    """Return the means (rows, cols, 2) of blocks of taxels, ignoring NaN; NaN for empty blocks."""
    if block == 1:
        return plane

    def total(values: Floats) -> Floats:
        rows, cols = (np.arange(0, size, block) for size in plane.shape[:2])
        sums: Floats = np.add.reduceat(np.add.reduceat(values, rows, axis=0), cols, axis=1)
        return sums

    count = total(np.isfinite(plane).astype(float))
    return total(np.nan_to_num(plane)) / np.where(count, count, np.nan)


def round_number(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is at most a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))
