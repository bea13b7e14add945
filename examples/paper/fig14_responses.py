"""Fig. 14: the three-axial response of one taxel under a bump to four materials pulled over the surface."""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim
from examples.paper.drawing import figure, save
from examples.paper.pulls import ARRAY, BEGIN, FRAME, Pull, all_pulls
from tactile.simulator.bump_cover import Bumps
from tactile.simulator.contacts.materials import PRESETS


def tone(made: Pull) -> float:
    """Return the frequency [Hz] of the largest component of a pull's normal strain."""
    normal = made.strains[BEGIN:, 2]
    power = np.abs(np.fft.rfft((normal - normal.mean()) * np.hanning(normal.size))) ** 2
    return float(np.fft.rfftfreq(normal.size, FRAME)[power.argmax()])


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 14: material, force and motion from the normal strain, the shears' ratio and their size."""
    pulls = all_pulls()
    screws = [made for made in pulls if made.material == "screw"]
    off = max(abs(tone(made) * PRESETS["screw"].period / made.speed - 1) for made in screws)
    turns, shares = [], []
    for made in pulls:
        x, y = made.strains[BEGIN:, :2].T
        turn = np.arctan2(y.mean(), x.mean()) - made.direction
        turns.append(abs(np.rad2deg(np.arctan2(np.sin(turn), np.cos(turn)))))
        shares.append(made.points[:, 0].mean() / made.friction)
    sensitivity = np.array([-made.strains[BEGIN:, 2].mean() / made.force for made in pulls])
    level = float(np.abs(sensitivity / sensitivity.mean() - 1).max())
    by_force = [share for _, share in sorted(zip((made.force for made in pulls), shares, strict=True))]
    weak, strong = np.mean(by_force[:4]), np.mean(by_force[-4:])
    if folder is not None:
        draw(pulls, folder / "fig14_responses.png")
    return [
        Claim("14", "the normal component follows the fine structure: tone of the screw's thread", "yes",
              f"speed / period within {off:.1%}", off < 0.05, "a thread of 0.5 mm at 4-6 mm/s, sampled every 15 ms"),
        Claim("14", "its mean is proportional to the pressing force", "yes", f"within {level:.1%}", level < 0.1),
        Claim("14", "the ratio of the shears gives the direction of motion", "yes",
              f"within {max(turns):.2f} degrees", max(turns) < 5),
        Claim("14", "shear over normal is the coefficient of friction", "yes",
              f"{min(shares):.2f} to {max(shares):.2f} of it", min(shares) > 0.95 and max(shares) < 1.05,
              f"a bump turns shear into less strain than pressure, and the share follows the force: {weak:.2f} in the "
              f"four weakest pulls, {strong:.2f} in the four strongest; by small strains with a stuck top of 0.1 mm it "
              f"is {stuck():.2f}"),
    ]  # fmt: skip


def stuck() -> float:
    """Return the strain ratio of shear and normal per unit of friction, at small strain."""
    table = Bumps().response(ARRAY, "strain")
    return float(abs(table.shear[0, 0, 1] / table.normal[0, 0, 0]))


def draw(pulls: tuple[Pull, ...], path: Path) -> None:
    """Write the figure: the first pull of each material."""
    drawn, panels = figure(1, len(PRESETS), (10, 2.0))
    for axes, material in zip(panels[:, 0], PRESETS, strict=True):
        made = next(made for made in pulls if made.material == material)
        t = np.arange(len(made.strains)) * FRAME
        axes.plot(t, -1e2 * made.strains[:, 2], color="black", label="normal, pressed is positive")
        for k, name in enumerate("xy"):
            axes.plot(t, 1e2 * made.strains[:, k], linestyle=":", label=f"shear {name}")
        degrees = np.rad2deg(made.direction)
        axes.set_title(
            f"{material}: {made.force * 1e3:.0f} mN, {made.speed * 1e3:.1f} mm/s, {degrees:.0f}°",
            loc="left",
            fontsize=10,
        )
        axes.set(ylabel="strain [%]", xlim=(0, t[-1]))
    panels[0, 0].legend(ncols=3, loc="lower right", bbox_to_anchor=(1, 1), frameon=False)  # above the curves
    panels[-1, 0].set_xlabel("time [s]")
    save(drawn, path)
