"""Fig. 6: effect of a wrong normal-to-shear ratio on the places and forces of located loads.

A needle presses with 20 mN on a grid of points over one taxel, 200 um deep. The exact strains are turned into
readings of a sensor with beta_ns = 1, and the loads are located with beta_ns wrong by a factor.
"""

from pathlib import Path
from typing import Any

import numpy as np

from examples.paper.claims import Claim
from examples.paper.drawing import figure, save
from examples.paper.needle import DEPTH, FORCE, Located, Scan, locate, scan
from tactile.calibration.gains import Gains

FACTORS = (0.75, 0.9, 1.0, 1.1, 1.25, 1.5)
GRID = np.linspace(-250e-6, 250e-6, 11)


def shrinkage(made: Scan, found: Located, radius: float) -> float:
    """Return the located over the true distance from the taxel, at the points nearest to a radius [m]."""
    rho = np.hypot(*np.moveaxis(made.places, -1, 0))
    at = np.abs(rho - radius) == np.abs(rho - radius).min()
    return float((np.hypot(*np.moveaxis(found.places, -1, 0))[at] / rho[at]).mean())


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 6: the inverse is exact with the true ratio; a wrong one shrinks or expands the map."""
    fine = scan(GRID, half=float(GRID[-1]))
    every = round(len(fine.times[0]) / (len(GRID) - 1))
    made = Scan(fine.times[:, ::every], fine.places[:, ::every], fine.readings[:, ::every])
    found = {factor: locate(made, Gains(factor, 1.0)) for factor in FACTORS}
    force = np.abs(found[1.0].force / FORCE - 1).max()
    off = found[1.0].error(made, 1.0)
    near, far = ({factor: shrinkage(made, at, radius) for factor, at in found.items()} for radius in (50e-6, 250e-6))
    bends = max(abs(near[factor] - far[factor]) for factor in FACTORS)
    if folder is not None:
        draw(made, found, folder / "fig06.png")
    return [
        Claim("6", "all effects off, true beta_ns: the inverse is exact", "errorless",
              f"place within {off * 1e6:.0e} um, force within {force:.0e}", off < 1e-15 and force < 1e-12),
        Claim("6", "beta_ns too small (0.75 x): located over true distance", "shrinks, not by one factor",
              f"{near[0.75]:.3f} at 50 um, {far[0.75]:.3f} at 250 um",
              near[0.75] < 1 and far[0.75] < 1 and bends > 0.01),
        Claim("6", "beta_ns too large (1.5 x): the same", "swells",
              f"{near[1.5]:.3f} at 50 um, {far[1.5]:.3f} at 250 um",
              near[1.5] > 1 and far[1.5] > 1),
        Claim("6", "the located force changes with it (0.75 x, 1.5 x at 250 um)", "yes",
              ", ".join(f"{found[factor].force[5, -1] * 1e3:.1f} mN" for factor in (0.75, 1.5)) + " for 20 mN",
              bool(found[0.75].force[5, -1] < FORCE < found[1.5].force[5, -1])),
    ]  # fmt: skip


def draw(made: Scan, found: dict[float, Located], path: Path) -> None:
    """Write the six panels."""
    from matplotlib.colors import LogNorm  # slow to import

    drawn, panels = figure(3, 2, (3.7, 3.7))
    style: dict[str, Any] = {"norm": LogNorm(10, 40), "cmap": "coolwarm", "edgecolors": "0.25", "linewidth": 0.5}
    for panel, (factor, located) in zip(panels.flat, found.items(), strict=True):
        dx, dy = np.moveaxis(located.places, -1, 0) * 1e6
        panel.plot(dx, dy, dx.T, dy.T, color="0.8", linewidth=0.8, zorder=1)
        panel.scatter(*(made.places.reshape(-1, 2).T * 1e6), marker="+", s=18, color="0.45", linewidth=0.7, zorder=2)
        points = panel.scatter(dx, dy, s=38 * located.force / FORCE, c=located.force * 1e3, zorder=3, **style)
        panel.set(aspect="equal", xlim=(-310, 310), ylim=(310, -310), xlabel="x [µm]", ylabel="y [µm]")
        panel.set_title(f"$\\beta_{{ns}}$ = {factor:g} × the true one")
    ticks = (10, 15, 20, 30, 40)
    drawn.colorbar(points, ax=panels, label="located force [mN], true: 20 mN", ticks=ticks, format="%d")
    save(drawn, path, f"Loads on a grid (+), located by one taxel {DEPTH * 1e6:g} µm deep (dots; size: force)")
