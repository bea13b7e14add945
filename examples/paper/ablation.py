"""Ablation study: which errors of sect. 4.1 reproduce which of the paper's findings, one at a time and together.

``python -m examples.paper.ablation [-o FOLDER] [--json]``. The paper found beta_ns = 1.46, a precision of 3-5 um within
150 um, a speed of 0.45 instead of 0.5 mm/s that a slightly thicker cover corrects, and far away a map like that of an
underestimated beta_ns. All sensors here have equal gains: beta_ns = 1 is true.
"""

from pathlib import Path
from typing import Any

from examples.paper.claims import study
from examples.paper.drawing import figure, plot_map, save
from examples.paper.needle import FORCE, NEAR
from examples.paper.skins import SKINS, Skin, Trial, on_the_bench

FORMATS = {
    "beta": "{:.3f}", "speed": "{:.3f} mm/s", "thicker": "{:.3f} x", "error": "{:.1f} um", "mended": "{:.1f} um",
    "needed": "{:.2f} x", "bend": "{:.2f}", "force": "{:.2f}",
}  # fmt: skip
"""Columns of the table: see `Trial`; ``thicker``: true over located speed; ``force``: located over true."""


def line(skin: Skin, trial: Trial) -> dict[str, Any]:
    """Return the results of a trial by `FORMATS`, and the paper's findings that it reproduces."""
    error, mended = (located.error(trial.made) * 1e6 for located in (trial.located, trial.mended))
    force = float(trial.located.force[trial.made.within(NEAR)].mean() / FORCE)
    found = {
        "beta_ns > 1": trial.beta > 1.05,
        "slow": trial.speed < 0.49e-3,
        "bent": trial.needed > 1.05 and trial.bend > 1,
        "3-5 um": 3 <= mended <= 5,
    }
    return {
        "skin": skin.name, "beta": trial.beta, "speed": trial.speed * 1e3, "thicker": 0.5e-3 / trial.speed,
        "error": error, "mended": mended, "needed": trial.needed, "bend": trial.bend, "force": force,
        "brings_back": [name for name, is_found in found.items() if is_found],
    }  # fmt: skip


def cells(each: dict[str, Any]) -> list[str]:
    """Return the row of the table."""
    numbers = (form.format(each[name]) for name, form in FORMATS.items())
    return [each["skin"], *numbers, ", ".join(each["brings_back"])]


def draw(trials: list[tuple[Skin, Trial]], path: Path) -> None:
    """Write the maps of all skins."""
    columns = 6
    drawn, panels = figure(columns, -(-len(trials) // columns), (2.6, 2.7))
    for axes in panels.flat[len(trials) :]:
        axes.axis("off")
    for axes, (skin, trial) in zip(panels.flat, trials, strict=False):
        plot_map(axes, trial, "0.85", "tab:red", xticks=[], yticks=[])
        axes.set_title(f"{skin.name}\n{trial.beta:.2f}, {trial.speed * 1e3:.2f} mm/s", fontsize=9)
    save(drawn, path, "True lines (grey) and located ones (red); beta_ns by eq. (18), speed; circle: 150 µm")


def main() -> None:
    """Try all skins."""
    trials = [(skin, on_the_bench(skin)) for skin in SKINS]
    lines = [line(skin, trial) for skin, trial in trials]
    folder = study(__doc__.splitlines()[0], lines, map(cells, lines), ("skin", *FORMATS, "brings back"))
    if folder is not None:
        draw(trials, folder / "ablation.png")


if __name__ == "__main__":
    main()
