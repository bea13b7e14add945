"""Fig. 6: what a wrong normal-to-shear ratio does to the places and sizes of located loads.

A needle presses with 20 mN on a grid of points over one taxel, 200 um deep. The exact strains are turned into
readings of a sensor with beta_ns = 1, and the loads are located with beta_ns wrong by a factor.
"""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim, alone
from examples.paper.needle import DEPTH, FORCE, Located, Scan, figure, locate, scan
from tactile.calibration.gains import Gains

FACTORS = (0.75, 0.9, 1.0, 1.1, 1.25, 1.5)
GRID = np.linspace(-250e-6, 250e-6, 11)


def shrinking(made: Scan, found: Located, radius: float) -> float:
    """Found over true distance from the taxel, at the points nearest to a radius [m]."""
    rho = np.hypot(*np.moveaxis(made.places, -1, 0))
    at = np.abs(rho - radius) == np.abs(rho - radius).min()
    return float((np.hypot(*np.moveaxis(found.places, -1, 0))[at] / rho[at]).mean())


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 6: with the true ratio the inverse is exact; a wrong one shrinks or swells the map."""
    fine = scan(GRID, half=float(GRID[-1]))
    every = round(len(fine.times[0]) / (len(GRID) - 1))
    made = Scan(fine.times[:, ::every], fine.places[:, ::every], fine.readings[:, ::every])
    found = {factor: locate(made, Gains(factor, 1.0)) for factor in FACTORS}
    force = np.abs(found[1.0].force / FORCE - 1).max()
    off = found[1.0].error(made, 1.0)
    near, far = ({factor: shrinking(made, at, radius) for factor, at in found.items()} for radius in (50e-6, 250e-6))
    bends = max(abs(near[factor] - far[factor]) for factor in FACTORS)
    if folder is not None:
        draw(made, found, folder / "fig06.png")
    return [
        Claim("6", "all effects off, true beta_ns: the inverse is exact", "errorless",
              f"place within {off * 1e6:.0e} um, force within {force:.0e}", off < 1e-15 and force < 1e-12),
        Claim("6", "beta_ns too small (0.75 x): found over true distance", "shrinks, not by one factor",
              f"{near[0.75]:.3f} at 50 um, {far[0.75]:.3f} at 250 um",
              near[0.75] < 1 and far[0.75] < 1 and bends > 0.01),
        Claim("6", "beta_ns too large (1.5 x): the same", "swells",
              f"{near[1.5]:.3f} at 50 um, {far[1.5]:.3f} at 250 um",
              near[1.5] > 1 and far[1.5] > 1),
        Claim("6", "the load's size changes with it (0.75 x, 1.5 x at 250 um)", "it does",
              ", ".join(f"{found[factor].force[5, -1] * 1e3:.1f} mN" for factor in (0.75, 1.5)) + " for 20 mN",
              bool(found[0.75].force[5, -1] < FORCE < found[1.5].force[5, -1])),
    ]  # fmt: skip


def draw(made: Scan, found: dict[float, Located], path: Path) -> None:
    """Write the six panels."""
    from matplotlib.colors import LogNorm  # slow to import

    drawn, panels = figure(3, 2, (3.7, 3.7))
    for panel, (factor, located) in zip(panels.flat, found.items(), strict=True):
        dx, dy = np.moveaxis(located.places, -1, 0) * 1e6
        for grid_x, grid_y in ((dx, dy), (dx.T, dy.T)):
            panel.plot(grid_x, grid_y, color="0.8", linewidth=0.8, zorder=1)
        panel.scatter(*(made.places.reshape(-1, 2).T * 1e6), marker="+", s=18, color="0.45", linewidth=0.7, zorder=2)
        points = panel.scatter(
            dx,
            dy,
            s=38 * located.force / FORCE,
            c=located.force * 1e3,
            norm=LogNorm(10, 40),
            cmap="coolwarm",
            edgecolors="0.25",
            linewidth=0.5,
            zorder=3,
        )
        panel.set_title(f"$\\beta_{{ns}}$ = {factor:g} × the true one" if factor != 1 else "true $\\beta_{ns}$")
        panel.set(aspect="equal", xlim=(-310, 310), ylim=(310, -310))  # y runs down, as the rows do
    for panel in panels[-1]:
        panel.set_xlabel("x [µm]")
    for panel in panels[:, 0]:
        panel.set_ylabel("y [µm]")
    ticks = (10, 15, 20, 30, 40)
    drawn.colorbar(points, ax=panels, label="located force [mN], true: 20 mN", ticks=ticks, format="%d")
    drawn.suptitle(f"Loads on a grid (+) and where one taxel {DEPTH * 1e6:g} µm deep locates them (dots; size: force)")
    drawn.savefig(path, dpi=120)


if __name__ == "__main__":
    alone(compare)
