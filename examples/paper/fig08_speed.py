"""Fig. 8: speed of the needle from the located places on the centre line, and its linear correction."""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim
from examples.paper.drawing import figure, plot_curves, save
from examples.paper.needle import DEPTH, NEAR, NOISE, SPEED, typical
from examples.paper.skins import ALL, POINT, STRESS, THICK, Measured, Skin, Trial, betas, on_the_bench, under_covers

PAPER = 0.45e-3
"""[m/s] The paper's located speed; the true one is 0.5 mm/s."""


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 8: speed on the centre line within 150 um, before and after the linear constant."""
    ideal, noise = on_the_bench(Skin("ideal", ())), on_the_bench(Skin("noise", typical(*NOISE)))
    point, whole, stress = (on_the_bench(skin) for skin in (POINT, ALL, STRESS))
    if folder is not None:
        draw(((POINT, point), (ALL, whole), (STRESS, stress)), folder / "fig08.png")
    return [
        Claim("8", "all effects off: speed", "0.5 mm/s (true)", f"{mm(ideal.speed)} mm/s",
              abs(ideal.speed / SPEED - 1) < 1e-9, f"noise alone: {mm(noise.speed)} mm/s, not slower"),
        Claim("8", "sect. 4.1 except the taxel's area, cover 2 z: speed", "0.45 mm/s", f"{mm(point.speed)} mm/s",
              agrees(point.speed), "the needle's tip, the cover's bottom and rubber at high strain reduce it"),
        *(
            Claim("8", f"the same, a taxel that measures {quantity}, covers {THICK} z thick: speed", "0.45 mm/s",
                  ", ".join(mm(trial.speed) for trial in under) + " mm/s", agrees(under[0].speed), why(quantity, under))
            for quantity, under in under_covers()
        ),
        Claim("8", "all of sect. 4.1, taxel 300 um wide: speed", "0.45 mm/s", f"{mm(whole.speed)} mm/s",
              agrees(whole.speed), "a mean over that width does not agree with their taxel"),
        Claim("8", "a taxel that measures stress, no other effect: speed", "0.45 mm/s", f"{mm(stress.speed)} mm/s",
              agrees(stress.speed),
              f"with beta_ns = {stress.beta:.2f} one cause of two of the paper's results; but its lines bend inwards"),
        Claim("8", "a linear constant corrects it, like a slightly thicker cover", "a bit thicker",
              f"{point.depth / DEPTH:.3f} z: {mm(point.mended.speed(point.made))} mm/s, places within 150 um from "
              f"{point.located.error(point.made) * 1e6:.1f} to {point.mended.error(point.made) * 1e6:.1f} um",
              abs(point.mended.speed(point.made) / SPEED - 1) < 1e-3 and point.depth > DEPTH,
              "located lengths are proportional to the depth given to the inverse"),
    ]  # fmt: skip


def why(quantity: Measured, under: list[Trial]) -> str:
    """Return the conclusion from covers of all thicknesses."""
    verdict = f"at the cover's bottom, 1 z, where the paper's taxels are; beta_ns {betas(under)} (paper: 1.46)"
    if quantity == "strain":
        return f"{verdict}; a bonded bottom has no strain across it; the paper's cover is not 2 to 5 z thick"
    return f"{verdict}: at the bottom the speed agrees, and beta_ns is above 1 like the paper's"


def mm(speed: float) -> str:
    """Return a speed [m/s] in mm/s."""
    return f"{speed * 1e3:.3f}"


def agrees(speed: float) -> bool:
    """Return whether a speed is the paper's within 0.02 mm/s."""
    return abs(speed - PAPER) < 0.02e-3


def draw(trials: tuple[tuple[Skin, Trial], ...], path: Path) -> None:
    """Write the figure."""
    drawn, (panels,) = figure(len(trials))
    for axes, (skin, trial) in zip(panels, trials, strict=True):
        line = len(trial.made.times) // 2
        t, x = trial.made.times[line] - trial.made.times[line].mean(), trial.made.places[line, :, 0] * 1e6
        located, mended = (one.places[line, :, 0] * 1e6 for one in (trial.located, trial.mended))
        label = "depth {:.3g} z: {} mm/s".format
        curves = [
            (t, x, "-", "0.7", f"true: {mm(SPEED)} mm/s"),
            (t, located, ".", "tab:red", label(1, mm(trial.speed))),
            (t, mended, ".", "tab:blue", label(trial.depth / DEPTH, mm(trial.mended.speed(trial.made)))),
        ]
        axes.axhspan(-NEAR * 1e6, NEAR * 1e6, color="0.95", zorder=0)
        plot_curves(axes, curves, title=skin.name, xlabel="time [s]", ylim=(-1.2 * np.ptp(x) / 2, 350))
    panels[0].set_ylabel("located x [µm]; grey band: the fit")
    save(drawn, path)
