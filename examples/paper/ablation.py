"""Ablation study: which errors of sect. 4.1 reproduce which of the paper's findings, one at a time and together.

``python -m examples.paper.ablation [-o FOLDER] [--json]``. The paper found beta_ns = 1.46, a precision of 3-5 um within
150 um, a speed of 0.45 instead of 0.5 mm/s that a slightly thicker cover corrects, and far away a map like that of an
underestimated beta_ns. All sensors here have equal gains: beta_ns = 1 is true.
"""

from dataclasses import dataclass
from pathlib import Path

from examples.paper.claims import study
from examples.paper.drawing import figure, plot_map, save
from examples.paper.needle import FORCE, NEAR
from examples.paper.skins import SKINS, Skin, Trial, on_the_bench

HEADINGS = "skin", "beta_ns", "speed", "thicker", "error", "mended", "needed", "bend", "force", "brings back"


@dataclass(frozen=True)
class Line:
    """One line of the table: lengths in um, speed in mm/s, ``force`` located over true; see `Trial`."""

    skin: str
    beta: float
    speed: float
    thicker: float
    error: float
    mended: float
    needed: float
    bend: float
    force: float
    brings_back: tuple[str, ...]


def line(skin: Skin, trial: Trial) -> Line:
    """Return the results of a trial, and the paper's findings that it reproduces."""
    error, mended = (located.error(trial.made) * 1e6 for located in (trial.located, trial.mended))
    force = float(trial.located.force[trial.made.within(NEAR)].mean() / FORCE)
    found = {
        "beta_ns > 1": trial.beta > 1.05,
        "slow": trial.speed < 0.49e-3,
        "bent": trial.needed > 1.05 and trial.bend > 1,
        "3-5 um": 3 <= mended <= 5,
    }
    return Line(
        skin.name, trial.beta, trial.speed * 1e3, 0.5e-3 / trial.speed, error, mended, trial.needed, trial.bend, force,
        tuple(name for name, so in found.items() if so),
    )  # fmt: skip


def cells(each: Line) -> list[str]:
    """Return the row of the table."""
    numbers = f"{each.beta:.3f}", f"{each.speed:.3f} mm/s", f"{each.thicker:.3f} x", f"{each.error:.1f} um"
    more = f"{each.mended:.1f} um", f"{each.needed:.2f} x", f"{each.bend:.2f}", f"{each.force:.2f}"
    return [each.skin, *numbers, *more, ", ".join(each.brings_back)]


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
    folder = study(__doc__.splitlines()[0], lines, map(cells, lines), HEADINGS)
    if folder is not None:
        draw(trials, folder / "ablation.png")


if __name__ == "__main__":
    main()
