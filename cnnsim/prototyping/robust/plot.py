"""Draws what `robust` measured: share of wrong cells against error level."""

from pathlib import Path
from typing import Any

from cnnsim.prototyping.robust.robust import Curve, Robustness
from cnnsim.support.files import writing


def draw_robustness(found: Robustness, path: str | Path) -> None:
    """Write the three curves; the format follows the name's ending.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    figure = Figure(figsize=(11, 4.2), layout=ConstrainedLayoutEngine(rect=(0, 0.04, 1, 0.96)))
    figure.suptitle(f"{found.name}: how precise must a chip be?", fontsize=13)
    entries, bits, noise = figure.subplots(1, 3)
    _draw(entries, found.entries, 100.0, "relative error of every entry, σ [%]", found.draws)
    if found.margin.tolerated:
        bound = 100 * found.margin.tolerated
        entries.axvline(bound, color="#d55e00", linestyle="--")
        text = f"errors up to {bound:.3g} %\n{'are' if found.margin.exact else 'are surely'} harmless"
        entries.annotate(
            text, (bound, 0.97), (-4, 0), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="right", va="top", color="#d55e00", fontsize=9,
        )  # fmt: skip
    _draw(bits, found.bits, 1.0, "bits of an entry, sign included", None)
    bits.set_xscale("linear")
    bits.set_xticks(found.bits.levels)
    bits.invert_xaxis()
    _draw(noise, found.noise, 1.0, "noise on the picture, σ (black to white: 2)", found.draws)
    entries.set_ylabel("wrong cells [%]")
    figure.text(0.995, 0.005, f"shares of {found.judged_on}; seed {found.seed}", ha="right", va="bottom", fontsize=8)
    with writing(path) as beside:
        figure.savefig(beside, dpi=120)


def _draw(axes: Any, curve: Curve, scale: float, label: str, draws: int | None) -> None:
    levels = [scale * level for level in curve.levels]
    mean, worst = [100 * share for share in curve.mean], [100 * share for share in curve.worst]
    if draws is not None:
        axes.fill_between(levels, mean, worst, color="#cfe3f2", label=f"up to the worst of {draws} draws")
    axes.plot(levels, mean, "o-", color="#0072b2", markersize=4, label="mean" if draws else None)
    axes.set_xscale("log")
    axes.set_xlabel(label)
    axes.set_ylim(0, max(5.0, 1.08 * max(worst)))
    axes.grid(alpha=0.3)
    if draws is not None:
        axes.legend(loc="center left", fontsize=8, frameon=False)
