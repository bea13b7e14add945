"""Fig. 15: friction and roughness of four materials, eqs (19) and (20) on the strains of one taxel under a bump."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from examples.paper.claims import Claim
from examples.paper.drawing import figure, save
from examples.paper.pulls import FRAME, PULLS, WINDOW, Pull, all_pulls
from tactile.simulator.contacts.materials import PRESETS


def accuracy(pulls: tuple[Pull, ...], columns: slice = slice(None)) -> float:
    """Return the accuracy of a linear discriminant, cross-validated by pulls."""
    right = 0
    for left_out in range(PULLS):
        known = [made for k, made in enumerate(pulls) if k % PULLS != left_out]
        means, within = [], np.zeros(())
        for material in PRESETS:
            points = np.concatenate([made.points for made in known if made.material == material])[:, columns]
            means.append(points.mean(axis=0))
            within = within + np.cov(points.T).reshape(points.shape[1], -1)
        for made in pulls[left_out::PULLS]:
            right += int((classified(made.points[:, columns], np.array(means), within) == made.material).sum())
    return right / sum(len(made.points) for made in pulls)


def classified(
    points: NDArray[np.float64], means: NDArray[np.float64], within: NDArray[np.float64]
) -> NDArray[np.str_]:
    """Return the material with the nearest mean, by the Mahalanobis distance."""
    off = points[:, None] - means
    distance = np.einsum("nmi,ij,nmj->nm", off, np.linalg.inv(within), off)
    return np.array(list(PRESETS))[distance.argmin(axis=1)]


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 15: points of all pulls, and the accuracy of their classification."""
    pulls = all_pulls()
    count = sum(len(made.points) for made in pulls)
    both, friction, roughness = (accuracy(pulls, columns) for columns in (slice(None), slice(0, 1), slice(1, 2)))
    rough = [np.concatenate([one.points[:, 1] for one in pulls if one.material == name]) for name in PRESETS]
    spread = max(float(values.std(ddof=1) / values.mean()) for values in rough)
    if folder is not None:
        draw(pulls, folder / "fig15_classification.png")
    return [
        Claim("15", f"T = {WINDOW} frames of {FRAME * 1e3:g} ms average over", "2 s", f"{WINDOW * FRAME:.2f} s",
              abs(WINDOW * FRAME - 2) < 0.1, f"{count} points"),
        Claim("15", "friction and roughness separate the four materials, in pulls not trained on",
              "relatively separable", f"{both:.1%} of the points", both > 0.9,
              f"friction alone {friction:.1%}, roughness alone {roughness:.1%}; materials are simulated, with friction "
              "and lengths of such materials"),
        Claim("15", "the clouds of the materials overlap", "huge standard deviation",
              f"roughness up to +- {spread:.0%}, the clouds are separate", both < 1,
              "simulated pulls vary less: constant speed and mean force, no pulling by hand, no wear"),
    ]  # fmt: skip


def draw(pulls: tuple[Pull, ...], path: Path) -> None:
    """Write the figure."""
    drawn, ((axes,),) = figure(1, size=(6.4, 4.8))
    for material in PRESETS:
        points = np.concatenate([made.points for made in pulls if made.material == material])
        axes.plot(*points.T, ".", markersize=3, label=material)
    axes.set(xlabel="shear over normal strain, eq. (19)", ylabel="roughness [%], eq. (20)")
    axes.set_title(f"{WINDOW} frames of {FRAME * 1e3:g} ms each; every streak is one pull")
    axes.legend(markerscale=4)
    save(drawn, path)
