"""Section 2, the half-space: ways to sum loads, dtype, points of a taxel's area, cells of a contact, waves of a layer."""

from typing import Any

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.command_line import watched
from tactile.core.loads import COLUMNS, F, X, Y
from tactile.elastic.cells import uniform_cell
from tactile.elastic.direct import direct_sum
from tactile.elastic.discs import disc_load
from tactile.elastic.gauss import gauss
from tactile.elastic.halfspace import point_load
from tactile.elastic.influence import Influence
from tactile.elastic.layer_loads import layer_term
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.elastic.spectral import TractionTransform
from tests.benchmarks.accuracy.rounds import best_times, first_below
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.accuracy.waves import by_waves

BODY = Medium(2.4e6)
DEPTH = 1e-3
SUMS = (8, 16, 32, 64)
AREAS = (1, 2, 3, 4, 6, 8, 12)
CELLS = (2, 4, 8, 16, 32, 64, 128)
COUNTS = (2, 4, 6, 8, 12, 16, 24, 32)


def section() -> Section:
    """Measure all four."""
    parts = (_sums, _areas, _contacts, _layers)
    rows = [row for part in watched(parts, "half-space", len(parts)) for row in part()]
    area, disc = _costs(rows, "taxel area 0.3 z", "points"), _costs(rows, "Hertz contact, a = z", "cells a side")
    answer = (
        f"Half-space: how loads are summed changes nothing but the time (all ways agree to {_worst_sum(rows):.0e}); three "
        f"digits of a taxel's area take {area[1e-3]:g} x {area[1e-3]:g} points and six {area[1e-6]:g} x {area[1e-6]:g}; a "
        f"contact cut into cells needs {disc[1e-3]:g} a side for three digits, its circle in closed form gives them all."
    )
    return Section(
        "halfspace", "2. Half-space", answer, _text(rows), rows, lambda figure: _draw(figure, rows), (12, 8.5)
    )


def _row(family: str, way: str, size: float, error: float, seconds: float) -> dict[str, Any]:
    return {"family": family, "way": way, "size": size, "error": error, "seconds": seconds}


def _relative(found: Floats, exact: Floats) -> float:
    return float(np.abs(found - exact).max() / np.abs(exact).max())


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
        influence = Influence(at, DEPTH, loads[:, :2], BODY) if side <= 32 else None
        transforms = TractionTransform((side, side), (side, side), pitch, DEPTH, BODY)
        ways = {
            "direct": lambda at=at, loads=loads: direct_sum(at, DEPTH, loads[None], BODY)[0],
            "transforms": lambda t=traction, by=transforms: by(t),
            "NumPy, float32": lambda at=at, loads=loads: _numpy(at, loads, np.float32),
            "NumPy, float64": lambda at=at, loads=loads: _numpy(at, loads, np.float64),
        }
        if influence is not None:
            ways["matrix"] = lambda by=influence, loads=loads: by(loads[None, :, 2:])[0]
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


def _numpy(at: Floats, loads: Floats, kind: Any) -> Floats:
    return np.asarray(_formula(at.reshape(-1, 2), loads, kind), np.float64).reshape(at.shape[0], -1, 3)


def _areas() -> list[dict[str, Any]]:
    """A square taxel by Gauss points, against 40 x 40 of them."""
    rows = []
    at = np.stack(np.meshgrid(np.linspace(-2, 2, 9), [0.0]), axis=-1)[0] * DEPTH
    load = np.array([[0.0, 0.0, 0.05, 0.0, 0.2]])
    for share in (0.3, 1.0, 3.0):

        def mean(count: int, share: float = share) -> Floats:
            nodes, weights = gauss(count)
            steps = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) * share * DEPTH / 2
            felt = point_load(at[:, None] + steps, DEPTH, load, BODY)
            return np.asarray(np.einsum("npk,p->nk", felt, np.outer(weights, weights).ravel() / 4))

        exact = mean(40)
        times = best_times({str(n): lambda n=n, mean=mean: mean(n) for n in AREAS})
        rows += [_row(f"taxel area {share:g} z", "points", n, _relative(mean(n), exact), times[str(n)]) for n in AREAS]
    return rows


def _contacts() -> list[dict[str, Any]]:
    """Hertz' pressure cut into cells, as points and as squares, against the circle in closed form."""
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

        def squares(x: Floats = x, y: Floats = y, force: Floats = force, pitch: float = pitch) -> Floats:
            kernel = uniform_cell(at[:, None, 0] - x, at[:, None, 1] - y, DEPTH, pitch, BODY)[..., 2]
            return np.asarray(np.einsum("tck,c->tk", kernel, force / pitch**2))

        ways = {
            "as points": lambda points=points: direct_sum(at, DEPTH, points[None], BODY)[0],
            "as squares": squares,
        }
        times = best_times(ways, 3)
        found = {way: _relative(run(), exact) for way, run in ways.items()}
        rows += [_row("Hertz contact, a = z", f"cells a side, {way}", n, found[way], times[way]) for way in ways]
    circle = best_times({"c": lambda: disc_load(at, DEPTH, load, [radius], HERTZ, BODY)})["c"]
    rows.append(_row("Hertz contact, a = z", "circle in closed form", 1, 1e-15, circle))
    return rows


def _layers() -> list[dict[str, Any]]:
    """A point load on a layer of twice the depth: panels of waves, and the table that is used."""
    rows = []
    at = np.stack(np.meshgrid(np.linspace(0, 4, 17), [0.0]), axis=-1).reshape(-1, 2) * DEPTH
    load, thickness = np.array([[0.0, 0.0, 0.05, 0.0, 0.2]]), 2 * DEPTH
    half = point_load(at, DEPTH, load, BODY)
    exact = half + by_waves(at, DEPTH, load[0], thickness, BODY, 400)
    ways = {f"waves {n}": lambda n=n: half + by_waves(at, DEPTH, load[0], thickness, BODY, n) for n in COUNTS}
    ways["table"] = lambda: half + layer_term(at, DEPTH, load, thickness, BODY)
    times = best_times(ways, 3)
    for n in COUNTS:
        rows.append(
            _row(
                "layer of 2 z", "Gauss points of waves", n, _relative(ways[f"waves {n}"](), exact), times[f"waves {n}"]
            )
        )
    rows.append(_row("layer of 2 z", "table, made once", 1, _relative(ways["table"](), exact), times["table"]))
    return rows


def _worst_sum(rows: list[dict[str, Any]]) -> float:
    return max(row["error"] for row in rows if row["family"] == "sums" and "float32" not in row["way"])


def _costs(rows: list[dict[str, Any]], family: str, way: str) -> dict[float, float]:
    found = [(row["size"], row["error"]) for row in rows if row["family"] == family and row["way"].startswith(way)]
    return {wanted: first_below(found, wanted) for wanted in (1e-3, 1e-6)}


_TEXT = """\
**Ways to sum.** Random tractions on the taxels' own grid, n x n loads on n x n taxels, against the formula in 80 bits.
The direct sum, the influence matrix and the transforms agree to rounding; the scene takes the fastest and says which
(`tactile explain`). float32, tried in the same formula in NumPy, keeps six digits and takes {single:.2g} x the time of
float64 there (median): scenes are computed in float64.

| loads x taxels | {ways} |
{table}

**Points of a taxel's area.** Gauss points converge geometrically, faster the deeper the taxel. The effect `taxel_area`
takes as many as 1e-6 asks for.

**Contacts.** Cells that carry Hertz' pressure converge with the square of their number a side at best, because the
pressure has a vertical slope at the rim; squares are no better than points once cells are smaller than the depth. A
circle in closed form is exact and costs {circle:.2g} x what {cells} cells a side cost, the fewest that reach 1e-3.

**Layer.** What a bonded layer adds is an integral over waves that fall off exponentially: {waves:g} Gauss points reach
1e-6. The product keeps it as a table over the distance, made once for a depth, a Poisson's ratio and a quantity: error
{spline:.0e} of the peak."""


def _text(rows: list[dict[str, Any]]) -> str:
    ways = ("direct", "matrix", "transforms", "NumPy, float64", "NumPy, float32")
    lines = ["|---" * (len(ways) + 1) + "|"]
    for side in SUMS:
        cells = []
        for way in ways:
            found = [row for row in rows if (row["family"], row["way"], row["size"]) == ("sums", way, side)]
            cells.append(f"{found[0]['seconds'] * 1e3:.3g} ms, {found[0]['error']:.0e}" if found else "too large")
        lines.append(f"| {side}² x {side}² | " + " | ".join(cells) + " |")
    disc = [row for row in rows if row["family"].startswith("Hertz")]
    cells = _costs(rows, "Hertz contact, a = z", "cells a side, as points")[1e-3]
    reached = [row["seconds"] for row in disc if row["way"].endswith("as points") and row["size"] == cells]
    layer = [row for row in rows if row["family"].startswith("layer")]
    time = {(row["way"], row["size"]): row["seconds"] for row in rows if row["family"] == "sums"}
    single = float(np.median([time["NumPy, float32", n] / time["NumPy, float64", n] for n in SUMS]))
    return _TEXT.format(
        single=single,
        ways=" | ".join(ways), table="\n".join(lines), cells=f"{cells:g}", circle=disc[-1]["seconds"] / reached[0],
        waves=_costs(rows, "layer of 2 z", "Gauss")[1e-6], spline=layer[-1]["error"],
    )  # fmt: skip


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots(2, 2)
    (sums, area), (disc, layer) = axes
    for way in dict.fromkeys(row["way"] for row in rows if row["family"] == "sums"):
        found = [row for row in rows if row["family"] == "sums" and row["way"] == way]
        sums.loglog([r["seconds"] for r in found], [max(r["error"], 1e-17) for r in found], "o-", label=way)
        for r in found:
            sums.annotate(
                f"{r['size']:g}²",
                (r["seconds"], max(r["error"], 1e-17)),
                fontsize=7,
                xytext=(3, 3),
                textcoords="offset points",
            )
    sums.set(title="ways to sum n² loads on n² taxels", ylabel="largest error over the peak")
    for one, start, title in (
        (area, "taxel area", "points of a taxel's area"),
        (disc, "Hertz", "a contact in cells"),
        (layer, "layer", "a layer of 2 z"),
    ):
        for key in dict.fromkeys((r["family"], r["way"]) for r in rows if r["family"].startswith(start)):
            found = [r for r in rows if (r["family"], r["way"]) == key]
            label = key[0] if start == "taxel area" else key[1]
            one.loglog(
                [r["seconds"] for r in found],
                [max(r["error"], 1e-16) for r in found],
                "o-" if len(found) > 1 else "*",
                markersize=4 if len(found) > 1 else 12,
                label=label,
            )
            for r in found if len(found) > 1 else ():
                one.annotate(
                    f"{r['size']:g}",
                    (r["seconds"], max(r["error"], 1e-16)),
                    fontsize=7,
                    xytext=(3, 3),
                    textcoords="offset points",
                )
        one.set(title=title, ylabel="largest error over the peak")
    for one in axes.ravel():
        one.set_xlabel("best wall time [s]")
        one.legend(fontsize=8)
        one.grid(alpha=0.3)
