"""Fig. 6 of the paper: what a wrong normal-to-shear ratio does to the places and sizes of located loads.

A needle presses with 20 mN on a grid of points over one taxel, 200 um deep. The exact strains are turned into
readings of a sensor with beta_ns = 1, and the loads are located with beta_ns wrong by a factor.
"""

import argparse
from pathlib import Path

import numpy as np

from tactile.calibration import Gains
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse import invert_strain

FACTORS = (0.75, 0.9, 1.0, 1.1, 1.25, 1.5)
DEPTH, MODULUS, FORCE = 200e-6, 2.4e6, 0.02
GRID = np.linspace(-250e-6, 250e-6, 11)


def main(output: Path) -> None:
    """Write the six panels as a picture to ``output``."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.colors import LogNorm

    places = np.stack(np.meshgrid(GRID, GRID), axis=-1)
    loads = np.zeros((*places.shape[:2], 1, 5))
    loads[..., 0, :2], loads[..., 0, 4] = places, FORCE
    readings = point_load_strain((0.0, 0.0), DEPTH, loads, MODULUS)

    figure, panels = plt.subplots(2, 3, figsize=(11, 7.4), sharex=True, sharey=True, layout="constrained")
    for panel, factor in zip(panels.flat, FACTORS, strict=True):
        x, y, z = np.moveaxis(Gains(shear=factor, normal=1.0)(readings), -1, 0)
        dx, dy, force, _ = invert_strain(x, y, z, DEPTH, MODULUS, 0.0, 1)
        for grid_x, grid_y in ((dx, dy), (dx.T, dy.T)):
            panel.plot(grid_x * 1e6, grid_y * 1e6, color="0.8", linewidth=0.8, zorder=1)
        panel.scatter(*(places.reshape(-1, 2).T * 1e6), marker="+", s=18, color="0.45", linewidth=0.7, zorder=2)
        points = panel.scatter(
            dx * 1e6,
            dy * 1e6,
            s=38 * force / FORCE,
            c=force * 1e3,
            norm=LogNorm(10, 40),
            cmap="coolwarm",
            edgecolors="0.25",
            linewidth=0.5,
            zorder=3,
        )
        panel.set_title(f"$\\beta_{{ns}}$ = {factor:g} × the true one" if factor != 1 else "true $\\beta_{ns}$")
        panel.set_aspect("equal")
        panel.set_xlim(-310, 310)
        panel.set_ylim(310, -310)  # y runs down, as the rows do
    for panel in panels[-1]:
        panel.set_xlabel("x [µm]")
    for panel in panels[:, 0]:
        panel.set_ylabel("y [µm]")
    ticks = (10, 15, 20, 30, 40)
    figure.colorbar(points, ax=panels, label="located force [mN], true: 20 mN", ticks=ticks, format="%d")
    figure.suptitle("Loads on a grid (+) and where one taxel locates them (dots; their size is the force)")
    figure.savefig(output, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("fig6.png"), help="picture to write")
    main(parser.parse_args().output)
