"""Section 2, places: how far off loads are located, against pitch, depth, noise, and how many press at once."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cnnsim.support.command_line import watched
from tactile.finger import Finger
from tactile.settings import Settings
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.scaling.taxels import (
    DEPTH,
    MODULUS,
    PITCH,
    SIDE,
    Windows,
    array_of,
    frame_of,
    place_errors,
    random_loads,
)

SIDES, DEPTHS, NOISES, COUNTS = (2, 4, 8, 16, 32), (0.5e-3, 1.5e-3, 3e-3), (1e-4, 1e-3, 1e-2, 3e-2), (1, 2, 3, 8, 16)
APART = 4.0
"""Depths between loads, at least, where several press."""
GROSS = 1.0
"""Depths from which on a load counts as not found."""


def measured(side: int, pitch: float, depth: float, noise: float, count: int, cases: int) -> dict[str, Any]:
    """Return errors [mm] over random loads: as located, and by windows alone; and the share not found."""
    array, random = array_of(side, pitch, depth), np.random.default_rng((side, count, int(1e6 * noise)))
    finger, windows = Finger(array, MODULUS, Settings()), Windows(array)
    ways: dict[str, list[float]] = {"located": [], "window": []}
    for _ in range(cases):
        loads = random_loads(array, count, APART, random)
        frame = frame_of(array, loads, noise, random)
        ways["located"] += place_errors(finger.locate(frame), loads)
        places = windows.locate(frame)
        apart = (
            np.hypot(*(places[None] - loads[:, None, :2]).transpose(2, 0, 1))
            if len(places)
            else np.full((len(loads), 1), np.inf)
        )
        ways["window"] += apart.min(axis=1).tolist()
    row: dict[str, Any] = {
        "taxels a side": side,
        "pitch mm": 1e3 * pitch,
        "depth mm": 1e3 * depth,
        "noise": noise,
        "loads": count,
    }
    for way, errors in ways.items():
        found = np.array([error for error in errors if error < GROSS * depth])
        row[f"{way} mm"] = float(1e3 * np.sqrt((found**2).mean())) if len(found) else float("nan")
        row[f"{way} lost"] = 1 - len(found) / len(errors)
    return row


def section(cases: int = 60) -> Section:
    """Measure single loads over pitch, depth and noise, and several loads on 32 x 32 taxels."""
    rows: list[dict[str, Any]] = []
    plan: list[tuple[Any, ...]] = []
    for side in SIDES:
        plan += [("constant area", side, SIDE / side, DEPTH, noise, 1) for noise in NOISES]
        plan += [("constant pitch", side, PITCH, DEPTH, 1e-2, 1)]
    plan += [("depth", 8, PITCH, depth, noise, 1) for depth in DEPTHS for noise in NOISES]
    plan += [("several loads", 32, PITCH, DEPTH, 1e-2, count) for count in COUNTS]
    for what, side, pitch, depth, noise, count in watched(plan, "places", len(plan)):
        rows.append({"study": what, **measured(side, pitch, depth, noise, count, max(6, cases // count))})
    several = {row["loads"]: row for row in rows if row["study"] == "several loads"}
    lost = {way: [_percent(several[n][f"{way} lost"]) for n in (2, 3, 16)] for way in ("located", "window")}
    answer = (
        "Several loads on 32 x 32 taxels at 1 % noise: {} of two, {} of three and {} of "
        "sixteen loads are lost, at {} mm; windows of taxels within 2.5 depths of a peak alone lose {}, {} and {}."
    ).format(*lost["located"], f"{several[16]['located mm']:.2g}", *lost["window"])
    title = "2. How far off loads are located"
    return Section("places", title, answer, _text(rows), rows, lambda figure: _draw(figure, rows), (11, 7.5))


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


_TEXT = """\
Random loads of 0.35 to 0.65 N with some shear, noise relative to the strongest signal of the frame, root mean square of
the distance from the place; a load farther off than {gross:g} depth is lost. Constant area: {area:g} mm, so the pitch
is {area:g} mm over the taxels a side; constant pitch: {pitch:g} mm. Several loads stand {apart:g} depths apart or more.
*located* is what the pipeline says: on pads above 16 x 16 taxels loads far apart are fitted in windows, each to what
the loads of the others leave. *window*: windows alone, in which the other loads stay in the signals.

| study | taxels | pitch mm | depth mm | noise | loads | located | lost | window | lost |
|---|---|---|---|---|---|---|---|---|---|
{table}"""


def _text(rows: Iterable[dict[str, Any]]) -> str:
    lines = [
        f"| {row['study']} | {row['taxels a side']} x {row['taxels a side']} | {row['pitch mm']:.3g} | "
        f"{row['depth mm']:g} | {row['noise']:g} | {row['loads']} | {row['located mm']:.2g} mm | "
        f"{_percent(row['located lost'])} | {row['window mm']:.2g} mm | {_percent(row['window lost'])} |"
        for row in rows
    ]
    return _TEXT.format(gross=GROSS, area=1e3 * SIDE, pitch=1e3 * PITCH, apart=APART, table="\n".join(lines))


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    (pitch, size), (depth, loads) = figure.subplots(2, 2)
    for noise in NOISES:
        for axes, study, x in ((pitch, "constant area", "pitch mm"), (depth, "depth", "depth mm")):
            of = [row for row in rows if row["study"] == study and row["noise"] == noise]
            axes.loglog(
                [row[x] for row in of],
                [row["located mm"] for row in of],
                "o-",
                markersize=4,
                label=f"noise {noise:g}",
            )
            axes.set(xlabel=x.replace(" mm", " [mm]"), ylabel="error of the place [mm]")
    pitch.set_title(f"one load, {1e3 * SIDE:g} mm wide array")
    depth.set_title("one load, 8 x 8 taxels")
    for study in ("constant area", "constant pitch"):
        of = [row for row in rows if row["study"] == study and row["noise"] == 1e-2]
        size.loglog(
            [row["taxels a side"] for row in of], [row["located mm"] for row in of], "o-", markersize=4, label=study
        )
    size.set(title="one load, 1 % noise", xlabel="taxels a side", ylabel="error of the place [mm]")
    several = [row for row in rows if row["study"] == "several loads"]
    for way in ("located", "window"):
        loads.plot(
            [row["loads"] for row in several],
            [100 * row[f"{way} lost"] for row in several],
            "o-",
            markersize=4,
            label=way,
        )
    loads.set(title="several loads, 32 x 32, 1 % noise", xlabel="loads", ylabel="lost [%]")
    for axes in (pitch, size, depth, loads):
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3, which="both")
