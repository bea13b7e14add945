"""Fig. 5: the three components along the centre line, and the normal-to-shear sensitivity from their extrema."""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim
from examples.paper.drawing import figure, plot_curves, save
from examples.paper.needle import DEPTH, NOISE, Scan, scan, typical
from tactile.calibration.gains import Gains
from tactile.calibration.sensitivity import EXTREMA_RATIO, beta_from_scan

TRUE = Gains(shear=1.46, normal=1.0)
"""Gains of the simulated sensor: the paper's ratio."""
RUNS = 6
HALF = 500e-6


def beta(made: Scan) -> float:
    """Return beta_ns by eq. (18) from the middle line."""
    line = made.readings[len(made.readings) // 2]
    return beta_from_scan(line[:, 0], line[:, 2]).beta


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 5: places and ratio of the extrema, and beta_ns from six noisy scans."""
    ideal = scan(half=HALF)
    x, (u_xz, u_yz, u_zz) = ideal.places[0, :, 0], ideal.readings[0].T
    swing, ratio = abs(x[u_xz.argmin()]) / DEPTH, np.abs(u_zz).max() / np.abs(u_xz).max()
    runs = [scan(effects=typical(*NOISE), gains=TRUE, seed=seed, half=HALF) for seed in range(RUNS)]
    found = np.array([beta(run) for run in runs])
    mean, spread = float(found.mean()), float(found.std(ddof=1))
    bonded = beta(scan(effects=typical("finite_thickness"), half=HALF))
    stress = beta(scan(quantity="stress", half=HALF))
    if folder is not None:
        draw(ideal, runs[0], folder / "fig05.png")
    return [
        Claim("5", "on y = 0, u_zz is extreme at 0, u_xz at", "+-z/2", f"+-{swing:.3f} z",
              abs(swing - 0.5) < 1e-9 and float(abs(x[u_zz.argmin()])) < 1e-9 and not u_yz.any()),
        Claim("5", "ratio of these extrema, eq. (18)", "25 sqrt(5) / 24 = 2.3292", f"{ratio:.4f}",
              abs(ratio / EXTREMA_RATIO - 1) < 1e-9),
        Claim("5", f"a sensor with beta_ns = {TRUE.beta_ns:g} measured in {RUNS} noisy scans", "1.46 +- 0.04",
              f"{mean:.3f} +- {spread:.3f}", abs(mean - TRUE.beta_ns) <= 0.04 and spread <= 0.04,
              "the paper does not state its noise; the simulated noise is typical and the spread smaller"),
        Claim("5", "beta_ns is not 1: it depends on the sensor and on the cover's adhesion", "1.46",
              f"strain, equal gains, half-space: 1; layer 2 z thick: {bonded:.3f}; stress: {stress:.3f}",
              abs(stress - 1.5) < 1e-9,
              "a taxel of equal gains that measures stress instead of strain has exactly 3/2 in eq. (18), one sigma "
              "from the measured value"),
    ]  # fmt: skip


def draw(ideal: Scan, noisy: Scan, path: Path) -> None:
    """Write the figure."""
    drawn, (panels,) = figure(2, size=(5.6, 3.8))
    for axes, made, title in zip(panels, (ideal, noisy), ("exact", "beta_ns = 1.46, with noise"), strict=True):
        x, line = made.places[0, :, 0] * 1e6, made.readings[0].T * 1e3
        styles = ("C0", "x"), ("C1", "y"), ("k", "normal")
        curves = [(x, u, "-", *style) for u, style in zip(line, styles, strict=True)]
        at = [line[0].argmin(), line[0].argmax(), line[2].argmin()]
        extrema = (x[at], line[[0, 0, 2], at], "o", "tab:red", "extremum")
        plot_curves(axes, [*curves, extrema], title=title, xlabel="needle's x [µm]", ylabel="reading [‰]")
    save(drawn, path)
