"""Section 2, the half-space: ways to sum loads, dtype, points of a taxel's area, a contact's cells."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.command_line import watched
from tactile.core.loads import COLUMNS, F, X, Y
from tactile.elastic.discs import disc_load
from tactile.elastic.gauss import gauss
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.elastic.sums.direct import direct_sum
from tactile.elastic.sums.spectral import TractionTransform
from tests.benchmarks.accuracy.rounds import best_times, first_below
from tests.benchmarks.accuracy.section import Section

Way = Callable[[], Floats]
BODY = Medium(2.4e6)
DEPTH = 1e-3
SUMS = (8, 16, 32, 64)
AREAS = (1, 2, 3, 4, 6, 8, 12)
CELLS = (2, 4, 8, 16, 32, 64, 128)


def section() -> Section:
    """Measure all three."""
    parts = (_sums, _areas, _contacts)
    rows = [row for part in watched(parts, "half-space", len(parts)) for row in part()]
    area, disc = _costs(rows, "taxel area 0.3 z", "points"), _costs(rows, "Hertz contact, a = z", "cells a side")
    answer = (
        f"All ways to sum loads agree to {_worst_sum(rows):.0e}. Three digits of a taxel's area take {area[1e-3]:g} x "
        f"{area[1e-3]:g} points, six take {area[1e-6]:g} x {area[1e-6]:g}. "
        f"A contact cut into cells needs {disc[1e-3]:g} cells a side for three digits; the closed form has all."
    )
    return Section("halfspace", "Half-space", answer, _text(rows), rows)


def _row(family: str, way: str, size: float, error: float, seconds: float) -> dict[str, Any]:
    return {"family": family, "way": way, "size": size, "error": error, "seconds": seconds}


def _relative(found: Floats, exact: Floats) -> float:
    return float(np.abs(found.reshape(exact.shape) - exact).max() / np.abs(exact).max())


def _sums() -> list[dict[str, Any]]:
    """A pressure map on the taxels' own grid, summed in four ways, float32 by the same formula."""
    rows = []
    for side in SUMS:
        random, pitch = np.random.default_rng(side), 5e-4
        at = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1) * pitch
        loads = np.zeros((side * side, COLUMNS))
        loads[:, X], loads[:, Y] = at[..., 0].ravel(), at[..., 1].ravel()
        loads[:, 2:] = random.normal(size=(side * side, 3)) * 1e-3
        exact = _numpy(at, loads, np.longdouble)
        traction = (loads[:, 2:] / pitch**2).reshape(side, side, 3)
        transforms = TractionTransform((side, side), (side, side), pitch, DEPTH, BODY)
        ways: dict[str, Way] = {
            "direct": partial(direct_sum, at, DEPTH, loads[None], BODY),
            "transforms": partial(transforms, traction),
            "NumPy, float32": partial(_numpy, at, loads, np.float32),
            "NumPy, float64": partial(_numpy, at, loads, np.float64),
        }
        times = best_times(ways)
        rows += [_row("sums", way, side, _relative(ways[way](), exact), times[way]) for way in ways]
    return rows


def _formula(at: Any, loads: Any, kind: Any) -> Any:
    """Eq. (1) in any dtype, in units of the depth, a block of taxels at a time."""
    z = kind(DEPTH)
    out = np.empty((len(at), 3), kind)
    scale = kind(1.5 / (2 * np.pi * BODY.modulus)) / z / z
    given = loads.astype(kind)
    for start in range(0, len(at), 256):
        block = at[start : start + 256].astype(kind)
        x, y = (block[:, None, 0] - given[:, X]) / z, (block[:, None, 1] - given[:, Y]) / z
        near = 1 / (1 + x * x + y * y)
        weight = (given[:, 2] * x + given[:, 3] * y + given[:, F]) * near * np.sqrt(near) * scale
        parts = (-3 * weight * near * x, -3 * weight * near * y, weight * (1 - 3 * near))
        out[start : start + 256] = np.stack([part.sum(-1) for part in parts], axis=-1)
    return out


def _numpy(at: Any, loads: Floats, kind: Any) -> Floats:
    return np.asarray(_formula(at.reshape(-1, 2), loads, kind), np.float64).reshape(at.shape[0], -1, 3)


def _areas() -> list[dict[str, Any]]:
    """A square taxel by Gauss points, against 40 x 40 of them."""
    rows = []
    at = np.stack(np.meshgrid(np.linspace(-2, 2, 9), [0.0]), axis=-1)[0] * DEPTH
    load = np.array([[0.0, 0.0, 0.05, 0.0, 0.2]])
    for share in (0.3, 1.0, 3.0):
        exact, name = _mean(at, load, share, 40), f"taxel area {share:g} z"
        ways: dict[str, Way] = {str(n): partial(_mean, at, load, share, n) for n in AREAS}
        times = best_times(ways)
        rows += [_row(name, "points", n, _relative(ways[str(n)](), exact), times[str(n)]) for n in AREAS]
    return rows


def _mean(at: Floats, load: Floats, share: float, count: int) -> Floats:
    """The mean over taxels ``share`` depths wide."""
    nodes, weights = gauss(count)
    steps = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) * share * DEPTH / 2
    felt = point_load(at[:, None] + steps, DEPTH, load, BODY)
    return np.asarray(np.einsum("npk,p->nk", felt, np.outer(weights, weights).ravel() / 4))


def _contacts() -> list[dict[str, Any]]:
    """Hertz' pressure cut into cells, as points, against the circle in closed form."""
    rows = []
    at = np.stack(np.meshgrid(np.linspace(-2, 2, 9), [0.0, 0.7]), axis=-1).reshape(-1, 2) * DEPTH
    load, radius = np.array([[0.0, 0.0, 0.0, 0.0, 1.0]]), DEPTH
    exact = disc_load(at, DEPTH, load, [radius], HERTZ, BODY)
    for n in CELLS:
        pitch = 2 * radius / n
        centre = (np.arange(n) + 0.5) * pitch - radius
        x, y = (part.ravel() for part in np.meshgrid(centre, centre))
        force = np.sqrt(np.maximum(1 - (x * x + y * y) / radius**2, 0))
        force /= force.sum()
        points = np.zeros((len(x), COLUMNS))
        points[:, X], points[:, Y], points[:, F] = x, y, force
        ways: dict[str, Way] = {"as points": partial(direct_sum, at, DEPTH, points[None], BODY)}
        times = best_times(ways, 3)
        found = {way: _relative(run(), exact) for way, run in ways.items()}
        rows += [_row("Hertz contact, a = z", f"cells a side, {way}", n, found[way], times[way]) for way in ways]
    circle = best_times({"c": lambda: disc_load(at, DEPTH, load, [radius], HERTZ, BODY)})["c"]
    rows.append(_row("Hertz contact, a = z", "circle in closed form", 1, 1e-15, circle))
    return rows


def _worst_sum(rows: list[dict[str, Any]]) -> float:
    """The largest error of the ways to sum in float64."""
    return max(row["error"] for row in rows if row["family"] == "sums" and "float32" not in row["way"])


def _costs(rows: list[dict[str, Any]], family: str, way: str) -> dict[float, float]:
    """The smallest size that reaches 1e-3 and 1e-6."""
    found = [(row["size"], row["error"]) for row in rows if row["family"] == family and row["way"].startswith(way)]
    return {wanted: first_below(found, wanted) for wanted in (1e-3, 1e-6)}


_TEXT = """\
**Ways to sum.** Random tractions on the taxels' own grid, n x n loads on n x n taxels, against the formula in 80
bits. The direct sum and the transforms agree to rounding. The scene takes the fastest and says which
(`tactile explain`). The same formula in NumPy in float32 keeps six digits and takes {single:.2g} x the time of float64
(median). A scene takes float64 unless it asks for less.

| loads x taxels | {ways} |
{table}

**Points of a taxel's area.** Gauss points converge geometrically, faster the deeper the taxel. The effect
`taxel_area` takes as many as the scene's accuracy needs.

**Contacts.** Cells with Hertz' pressure converge with the square of their number a side at best, because the pressure
has a vertical slope at the rim. A circle in closed form is exact and costs {circle:.2g} x what {cells} cells a side
cost, the fewest that reach 1e-3."""


def _text(rows: list[dict[str, Any]]) -> str:
    ways = ("direct", "transforms", "NumPy, float64", "NumPy, float32")
    lines = ["|---" * (len(ways) + 1) + "|"]
    of = {(row["way"], row["size"]): row for row in rows if row["family"] == "sums"}
    for side in SUMS:
        cells = [f"{of[way, side]['seconds'] * 1e3:.3g} ms, {of[way, side]['error']:.0e}" for way in ways]
        lines.append(f"| {side}² x {side}² | " + " | ".join(cells) + " |")
    disc = [row for row in rows if row["family"].startswith("Hertz")]
    enough = _costs(rows, "Hertz contact, a = z", "cells a side, as points")[1e-3]
    reached = [row["seconds"] for row in disc if row["way"].endswith("as points") and row["size"] == enough]
    seconds = [(of["NumPy, float32", n]["seconds"], of["NumPy, float64", n]["seconds"]) for n in SUMS]
    return _TEXT.format(
        single=float(np.median([single / double for single, double in seconds])), ways=" | ".join(ways),
        table="\n".join(lines), cells=f"{enough:g}", circle=disc[-1]["seconds"] / reached[0],
    )  # fmt: skip
