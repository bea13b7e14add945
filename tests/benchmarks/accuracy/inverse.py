"""Section 4, the inverse: printed against stable form, one taxel's answer against least squares, how many taxels."""

from functools import partial
from typing import Any

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.command_line import watched
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse.taxel import invert_strain
from tests.benchmarks.accuracy.rounds import best_times
from tests.benchmarks.accuracy.section import Section
from tests.kits.touch.pads import DEPTH, MODULUS, SCALE, array, as_row, locate
from tests.oracles.elastic.exact_inverse import exact_inverse
from tests.oracles.elastic.localise import bound
from tests.oracles.elastic.printed_inverse import printed_inverse

RATIOS = np.concatenate([np.geomspace(1e-8, 1, 33), np.sqrt(2) + np.array([-1e-6, 1e-6]), np.geomspace(2, 1e4, 17)])
SIDES = (2, 3, 4, 6, 8, 12, 16)
NOISES = (1e-5, 1e-4, 1e-3, 1e-2)
TRIALS = 60
WAYS = "least squares", "one taxel's own answer", "Cramer-Rao"


def section() -> Section:
    """Measure all three."""
    rows = [*forms(), *_noise()]
    worst = {
        (way, dtype): max(r["error"] for r in rows if (r["family"], r["way"]) == ("forms", f"{way}, {dtype}"))
        for way in ("stable", "printed")
        for dtype in ("float32", "float64")
    }
    few, many = (
        next(r for r in rows if (r["family"], r["way"], r["size"], r["noise"]) == ("noise", WAYS[0], n, 1e-2))
        for n in (2, 8)
    )
    answer = (
        f"The stable form is right to {worst['stable', 'float64']:.0e} wherever the load is. The printed form "
        "loses all digits above the taxel and on the ring. "
        f"With 1 % noise 8 x 8 taxels are {few['error'] / many['error']:.2g} x as precise as 2 x 2, for "
        f"{many['seconds'] / few['seconds']:.2g} x the time."
    )
    return Section("inverse", "Inverse", answer, _text(rows), rows)


def _row(
    family: str, way: str, size: float, noise: float, error: float, seconds: float, force: float = 0.0
) -> dict[str, Any]:
    return {
        "family": family, "way": way, "size": size, "noise": noise, "error": error, "force error": force,
        "seconds": seconds,
    }  # fmt: skip


def forms() -> list[dict[str, Any]]:
    """Larger relative error of a normal load's distance and force, over rho / z, from the same rounded signals."""
    t = RATIOS**2
    felt = np.stack([3 * RATIOS, t - 2], axis=-1) / ((1 + t) ** 2.5)[:, None]
    rows = []
    for dtype in (np.float32, np.float64):
        # what the rounding of the signals does is not the form's fault: the truth is that of the rounded ones
        given = felt.astype(dtype)
        true = np.array([exact_inverse(*pair) for pair in given])
        zero = np.zeros(len(given), dtype)
        # E is such that 4 pi E z^2 / 3 = 1
        dx, _, force, _ = invert_strain(given[:, 0], zero, given[:, 1], 1.0, 3 / (4 * np.pi), 0.0, 1)
        for way, found in (
            ("stable", (np.abs(dx), force)),
            ("printed", printed_inverse(given[:, 0], given[:, 1], dtype)),
        ):
            error = np.abs(np.stack(found, axis=-1).astype(np.float64) / true - 1).max(axis=1)
            error = np.where(np.isfinite(error), np.clip(error, 1e-17, 1), 1.0)
            name = f"{way}, {np.dtype(dtype).name}"
            rows += [_row("forms", name, r, 0.0, float(e), 0.0) for r, e in zip(RATIOS, error, strict=True)]
    return rows


def _noise() -> list[dict[str, Any]]:
    """Errors of place and normal force of a load: the strongest taxel alone, all of them, and the least possible."""
    rows = []
    for side in watched(SIDES, "inverse", len(SIDES)):
        at, random = array(side, side), np.random.default_rng(side)
        for level in NOISES:
            errors: dict[str, list[tuple[float, float]]] = {way: [] for way in WAYS}
            for _ in range(TRIALS):
                place = at.mean(axis=(0, 1)) + random.uniform(-1, 1, 2) * DEPTH
                load = np.array([*place, 0.15, -0.1, 0.5])
                strain = point_load_strain(at, DEPTH, [load], MODULUS)
                noise = level * float(np.abs(strain).max())
                noisy = strain + random.normal(size=strain.shape) * noise
                least = bound(partial(_strain, at), load, noise, SCALE)
                gaps = as_row(locate(at, noisy)) - load, _one(at, noisy) - load, least
                for way, gap in zip(WAYS, gaps, strict=True):
                    errors[way].append((float(np.hypot(*gap[:2]) / DEPTH), float(abs(gap[4]) / load[4])))
            seconds = best_times({"": partial(locate, at, noisy)}, 20)[""]
            for way, found in errors.items():
                near, force = np.sqrt(np.mean(np.square(found), axis=0)).tolist()
                rows.append(_row("noise", way, side, level, near, seconds if way == WAYS[0] else 0.0, force))
    return rows


def _strain(at: Floats, loads: Floats) -> Floats:
    return point_load_strain(at, DEPTH, loads, MODULUS)


def _one(at: Floats, strain: Floats) -> Floats:
    """The load that the strongest taxel finds by itself, taking it as normal."""
    x, y, z = np.moveaxis(strain, -1, 0)
    dx, dy, force, _ = invert_strain(x, y, z, DEPTH, MODULUS, 0.0, 1)
    best = np.unravel_index(np.abs(z).argmax(), z.shape)
    return np.array([*(at[best] + [dx[best], dy[best]]), 0.0, 0.0, force[best]])


_TEXT = """\
**Form.** For the same signals, taken as exact, the root of eq. (4) in 50 digits is the truth. The printed form
subtracts two nearly equal numbers right above the taxel and divides 0 by 0 on the ring rho = sqrt(2) z. The stable
form, whose sums have terms of one sign, costs the same and is off by at most {stable32:.0e} in float32 and
{stable64:.0e} in float64.

**Noise and taxels.** Loads with shear within a depth of the array's middle, {trials} draws a point. The strongest
taxel alone finds the place as well as the noise lets it, but only the sum Q x + R y + F z: taken as the normal force
it is off by {bias:.0%} however small the noise. All signals together, by least squares from the taxels' consensus,
find place and components at the Cramer-Rao bound:

| taxels | time of a frame | place, 1 % noise [z] | place, 0.1 % | F, 1 % noise | place to the bound |
|---|---|---|---|---|---|
{table}

Taxels more than two depths from the load cost time and add little."""


def _text(rows: list[dict[str, Any]]) -> str:
    def worst(way: str) -> float:
        return max(row["error"] for row in rows if (row["family"], row["way"]) == ("forms", way))

    noise = {(r["way"], r["size"], r["noise"]): r for r in rows if r["family"] == "noise"}
    lines = []
    for side in SIDES:
        ours, less = noise["least squares", side, 1e-2], noise["least squares", side, 1e-3]
        ratio = ours["error"] / noise["Cramer-Rao", side, 1e-2]["error"]
        lines.append(
            f"| {side} x {side} | {ours['seconds'] * 1e6:.0f} us | {ours['error']:.2g} | {less['error']:.2g} | "
            f"{ours['force error']:.2%} | {ratio:.2f} |"
        )
    return _TEXT.format(
        stable32=worst("stable, float32"), stable64=worst("stable, float64"), trials=TRIALS, table="\n".join(lines),
        bias=noise[WAYS[1], 8, 1e-5]["force error"],
    )  # fmt: skip
