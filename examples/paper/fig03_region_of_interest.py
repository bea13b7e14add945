"""Fig. 3: u_zz under a normal point load, and the region in which it is negative."""

from pathlib import Path

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from examples.paper.claims import Claim
from examples.paper.drawing import figure, save
from examples.paper.needle import DEPTH, FORCE, MODULUS
from tactile.elastic.halfspace import point_load_strain


def strain(rho: float, depth: float = DEPTH) -> float:
    """u_zz at a distance [m] from the needle."""
    return float(point_load_strain((rho, 0.0), depth, [(0, 0, 0, 0, FORCE)], MODULUS)[2])


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 3: where u_zz is negative, and how strong it is there and beyond."""
    peak = -strain(0.0)
    turns = [brentq(strain, 0.1 * z, 5 * z, args=(z,), xtol=1e-18) / z for z in (DEPTH, 2 * DEPTH)]
    beyond = minimize_scalar(lambda rho: -strain(rho), bounds=(1.5 * DEPTH, 5 * DEPTH), method="bounded")
    share = -float(beyond.fun) / peak
    thick = -strain(0.0, 2 * DEPTH) / peak
    if folder is not None:
        draw(folder / "fig03.png")
    return [
        Claim("3", "u_zz < 0 within a radius of", "sqrt(2) z", f"{turns[0]:.6f} z",
              abs(turns[0] - np.sqrt(2)) < 1e-9, "eq. (1)"),
        Claim("3", "inside, the signal exceeds the noise; outside, u_zz is at most", "(poorly measurable)",
              f"{share:.1%} of the peak, at {float(beyond.x) / DEPTH:.2f} z", share < 0.05,
              "u_xz is 3 times as large there: the inverse still works, with more noise"),
        Claim("3", "a cover twice as thick: radius, and strain under the same load", "larger; less",
              f"{2 * turns[1] / turns[0]:.3f} x; {thick:.3f} x", turns[1] / turns[0] > 0.5 and thick < 1,
              "the radius is proportional to z, the strain to 1 / z^2"),
    ]  # fmt: skip


def draw(path: Path) -> None:
    """Write the figure."""
    side = np.linspace(-3, 3, 241) * DEPTH
    at = np.stack(np.meshgrid(side, side), axis=-1)
    u = point_load_strain(at, DEPTH, [(0, 0, 0, 0, FORCE)], MODULUS)[..., 2]
    drawn, ((plane, line),) = figure(2, size=(5.4, 4.2))
    image = plane.imshow(u * 1e3, extent=(-600, 600, 600, -600), cmap="RdBu", norm="symlog", vmin=-100, vmax=100)
    plane.contour(side * 1e6, side * 1e6, u, levels=[0.0], colors="black", linewidths=1)
    plane.set(title="u_zz; black: zero, at sqrt(2) z", xlabel="x [µm]", ylabel="y [µm]")
    drawn.colorbar(image, ax=plane, label="u_zz [‰], in decades beyond 1", pad=0.03)
    line.plot(side * 1e6, u[120] * 1e3, color="black")
    line.axhline(0, color="0.7", linewidth=0.8)
    for sign in (-1, 1):
        line.axvline(sign * np.sqrt(2) * DEPTH * 1e6, color="tab:red", linewidth=0.8)
    line.set(title="along y = 0; red: sqrt(2) z", xlabel="x [µm]", ylabel="u_zz [‰]")
    save(drawn, path)
