"""Fig. 14: the three-axial response to four materials pulled over the skin."""

from pathlib import Path

import numpy as np

from examples.paper.claims import Claim
from examples.paper.drawing import figure, save
from examples.paper.pulls import BEGIN, FRAME, Pull, all_pulls
from tactile.simulator.contacts.materials import PRESETS


def tone(made: Pull) -> float:
    """Return the frequency [Hz] of the largest component of a pull's normal force."""
    normal = made.load[BEGIN:, 2]
    power = np.abs(np.fft.rfft((normal - normal.mean()) * np.hanning(normal.size))) ** 2
    return float(np.fft.rfftfreq(normal.size, FRAME)[power.argmax()])


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 14: material and motion from the normal force, the shears' ratio and their size."""
    pulls = all_pulls()
    screws = [made for made in pulls if made.material == "screw"]
    off = max(abs(tone(made) * PRESETS["screw"].period / made.speed - 1) for made in screws)
    turns, mu = [], []
    for made in pulls:
        q, r, f = made.load[BEGIN:].T
        turn = np.arctan2(r.mean(), q.mean()) - made.direction
        turns.append(abs(np.rad2deg(np.arctan2(np.sin(turn), np.cos(turn)))))
        material, ratio = PRESETS[made.material], np.median((np.hypot(q, r)[f > 0]) / f[f > 0])
        mu.append(material.kinetic * 0.98 <= ratio <= material.static * 1.02)
    level = max(abs(float(made.load[BEGIN:, 2].mean()) / made.force - 1) for made in pulls)
    if folder is not None:
        draw(pulls, folder / "fig14_responses.png")
    return [
        Claim("14", "the normal component follows the fine structure: tone of the screw's thread", "yes",
              f"speed / period within {off:.1%}", off < 0.05, "a thread of 0.5 mm at 4-6 mm/s, sampled every 15 ms"),
        Claim("14", "its mean is the pressing force", "yes", f"within {level:.1%}", level < 0.1),
        Claim("14", "the ratio of the shears gives the direction of motion", "yes",
              f"within {max(turns):.2f} degrees", max(turns) < 5),
        Claim("14", "shear over normal is the coefficient of friction", "yes",
              f"between kinetic and static in {sum(mu)} of {len(mu)} pulls", all(mu),
              "the paper gives no coefficients; these are those of the simulated materials"),
    ]  # fmt: skip


def draw(pulls: tuple[Pull, ...], path: Path) -> None:
    """Write the figure: the first pull of each material."""
    drawn, panels = figure(1, len(PRESETS), (10, 2.0))
    for axes, material in zip(panels[:, 0], PRESETS, strict=True):
        made = next(made for made in pulls if made.material == material)
        t = np.arange(len(made.load)) * FRAME
        axes.plot(t, made.load[:, 2], color="black", label="normal")
        for k, name in enumerate("xy"):
            axes.plot(t, made.load[:, k], linestyle=":", label=f"shear {name}")
        degrees = np.rad2deg(made.direction)
        axes.set_title(f"{material}: {made.speed * 1e3:.1f} mm/s, {degrees:.0f}°", loc="left", fontsize=10)
        axes.set(ylabel="load [N]", xlim=(0, t[-1]))
    panels[0, 0].legend(ncols=3, loc="lower right", bbox_to_anchor=(1, 1), frameon=False)  # above the curves
    panels[-1, 0].set_xlabel("time [s]")
    save(drawn, path)
