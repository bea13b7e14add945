"""Fig. 8: the speed of the needle from the located places on the centre line, and the constant that mends it."""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim, alone
from examples.paper.needle import DEPTH, NEAR, NOISE, SPEED, figure, typical
from examples.paper.skins import (
    ALL,
    FEELS,
    POINT,
    STRESS,
    THICK,
    Feels,
    Skin,
    Trial,
    betas,
    covered,
    on_the_bench,
    spoken,
)

PAPER = 0.45e-3
"""[m/s] The paper's speed, where 0.5 mm/s are true."""


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 8: speed on the centre line within 150 um, before and after the constant."""
    ideal, noise = on_the_bench(Skin("ideal", ())), on_the_bench(Skin("noise", typical(*NOISE)))
    point, whole, stress = (on_the_bench(skin) for skin in (POINT, ALL, STRESS))
    if folder is not None:
        draw(((POINT, point), (ALL, whole), (STRESS, stress)), folder / "fig08.png")
    return [
        Claim("8", "all effects off: speed", "0.5 mm/s (true)", f"{mm(ideal.speed)} mm/s",
              abs(ideal.speed / SPEED - 1) < 1e-9, f"noise alone: {mm(noise.speed)} mm/s: no reason for less"),
        Claim("8", "sect. 4.1 but for the taxel's area, cover 2 z: speed", "0.45 mm/s", f"{mm(point.speed)} mm/s",
              alike(point.speed), "the needle's tip, the cover's bottom and rubber at high strain take it"),
        *(
            Claim("8", f"the same with a taxel that feels {feels}, covers {spoken(THICK)} z thick: speed", "0.45 mm/s",
                  ", ".join(mm(trial.speed) for trial in under) + " mm/s", alike(under[0].speed), why(feels, under))
            for feels, under in ((feels, [on_the_bench(covered(times, feels)) for times in THICK]) for feels in FEELS)
        ),
        Claim("8", "all of sect. 4.1, taxel 300 um wide: speed", "0.45 mm/s", f"{mm(whole.speed)} mm/s",
              alike(whole.speed), "so wide a mean does not fit their taxel"),
        Claim("8", "a taxel that feels stress, nothing else: speed", "0.45 mm/s", f"{mm(stress.speed)} mm/s",
              alike(stress.speed),
              f"with beta_ns = {stress.beta:.2f} one cause for two of the paper's figures; but its lines bend inwards"),
        Claim("8", "a linear constant mends it, like a slightly thicker cover", "a bit thicker",
              f"{point.depth / DEPTH:.3f} z: {mm(point.mended.speed(point.made))} mm/s, places within 150 um from "
              f"{point.located.error(point.made) * 1e6:.1f} to {point.mended.error(point.made) * 1e6:.1f} um",
              abs(point.mended.speed(point.made) / SPEED - 1) < 1e-3 and point.depth > DEPTH,
              "located lengths are proportional to the depth given to the inverse"),
    ]  # fmt: skip


def why(feels: Feels, under: list[Trial]) -> str:
    """What covers of all thicknesses say together."""
    said = f"judged at the cover's bottom, 1 z, where the paper's taxels lie; beta_ns {betas(under)} (paper: 1.46)"
    if feels == "strain":
        return f"{said}; a bonded bottom lets nothing strain across it: what fits at 2 to 5 z is not the paper's cover"
    return f"{said}: at the bottom the speed fits, and beta_ns lies on the paper's side of 1"


def mm(speed: float) -> str:
    """Metres as millimetres a second."""
    return f"{speed * 1e3:.3f}"


def alike(speed: float) -> bool:
    """Whether a speed is the paper's, to the digits it gives and the digit next to it."""
    return abs(speed - PAPER) < 0.02e-3


def draw(trials: tuple[tuple[Skin, Trial], ...], path: Path) -> None:
    """Write the picture."""
    drawn, (panels,) = figure(len(trials))
    for axes, (skin, trial) in zip(panels, trials, strict=True):
        line = len(trial.made.times) // 2
        t, x = trial.made.times[line] - trial.made.times[line].mean(), trial.made.places[line, :, 0] * 1e6
        axes.plot(t, x, color="0.7", label=f"true: {mm(SPEED)} mm/s")
        for located, colour, depth, speed in (
            (trial.located, "tab:red", DEPTH, trial.speed),
            (trial.mended, "tab:blue", trial.depth, trial.mended.speed(trial.made)),
        ):
            said = f"located with depth {depth / DEPTH:.3g} z: {mm(speed)} mm/s"
            axes.plot(t, located.places[line, :, 0] * 1e6, ".", markersize=3, color=colour, label=said)
        axes.axhspan(-NEAR * 1e6, NEAR * 1e6, color="0.95", zorder=0)
        axes.set(title=skin.name, xlabel="time [s]", ylim=(-1.2 * np.ptp(x) / 2, 350))
        axes.legend(fontsize=8, loc="upper left")
    panels[0].set_ylabel("located x [µm]; grey band: the fit")
    drawn.savefig(path, dpi=110)


if __name__ == "__main__":
    alone(compare)
