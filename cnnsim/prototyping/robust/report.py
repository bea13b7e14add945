"""Result of a robustness measurement: curves of the share of wrong cells over the errors, as text and as a plot."""

from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from cnnsim.plot.figures import given_or_new
from cnnsim.prototyping.robust.margin import Margin
from cnnsim.support import InputError
from cnnsim.support.files import writing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Kind = Literal["entries", "bits", "noise"]


@dataclass(frozen=True)
class Curve:
    """Share of wrong cells at each level: the mean over the draws, and the worst draw."""

    levels: tuple[float, ...]
    mean: tuple[float, ...]
    worst: tuple[float, ...]

    def largest_without_error(self) -> float | None:
        """Return the largest level up to which (levels ascending) no draw had a wrong cell, or None."""
        good = [level for level, _ in zip(self.levels, _until_wrong(self.worst), strict=False)]
        return good[-1] if good else None


@dataclass(frozen=True, repr=False)
class Robustness:
    """The result of `robust.measure`; ``judged_on``: the cells of which the shares are taken."""

    name: str
    margin: Margin
    judged_on: str
    entries: Curve
    bits: Curve
    noise: Curve
    draws: int
    seed: int

    def bits_needed(self) -> int | None:
        """Return the fewest bits from which on no cell is wrong, or None if 12 are not enough."""
        good = [int(bits) for bits, _ in zip(self.bits.levels[::-1], _until_wrong(self.bits.worst[::-1]), strict=False)]
        return good[-1] if good else None

    def __repr__(self) -> str:
        return f"Robustness({self.name!r}, judged on {self.judged_on}; {'; '.join(map(' '.join, self.rows()))})"

    def rows(self) -> list[tuple[str, str]]:
        """Return what was found in words: names and texts."""
        margin, bits = self.margin, self.bits_needed()
        found = [("margin", margin.why if margin.value is None else f"{margin.value:.4g} ({margin.why})")]
        if margin.tolerated is not None:
            percent = f"{'' if margin.exact else 'at least '}{100 * margin.tolerated:.3g} %"
            found.append(("entry errors", f"{percent} are harmless"))
        sigma, noise = self.entries.largest_without_error(), self.noise.largest_without_error()
        return [
            *found,
            ("random errors", f"{_level(sigma, 100, ' %')} (σ) without a wrong cell in {self.draws} draws"),
            ("bits", f"{'more than 12' if bits is None else bits} needed"),
            ("noise", f"{_level(noise, 1, '')} (σ; black to white is 2) without a wrong cell"),
        ]

    def plot(self, axes: "Axes | None" = None, kind: Kind = "entries") -> "Axes":
        """Draw one of the curves "entries", "bits" and "noise" into axes, or new ones, and return them.

        Raises:
            InputError: another curve.
        """
        if kind not in get_args(Kind):
            raise InputError(f"curve {kind!r}; {', '.join(get_args(Kind))} wanted")
        axes = self._draw(given_or_new(axes), kind)
        if kind != "bits":
            axes.legend(fontsize=8)
        return axes

    def _draw(self, axes: "Axes", kind: Kind) -> "Axes":
        if kind == "bits":
            _draw(axes, self.bits, 1.0, "bits of an entry, sign included", None)
            axes.set_xscale("linear")
            axes.set_xticks(self.bits.levels)
            axes.invert_xaxis()
        elif kind == "noise":
            _draw(axes, self.noise, 1.0, "noise on the picture, σ (black to white: 2)", self.draws)
        else:
            _draw(axes, self.entries, 100.0, "relative error of every entry, σ [%]", self.draws)
            if self.margin.tolerated:
                bound = 100 * self.margin.tolerated
                text = f"errors up to {bound:.3g} % {'are' if self.margin.exact else 'are surely'} harmless"
                axes.axvline(bound, color="#d55e00", linestyle="--", label=text)
        axes.set_ylabel("wrong cells [%]")
        return axes

    def figure(self) -> Any:
        """Return a figure of matplotlib with the three curves."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11, 4.4), layout="constrained")
        figure.suptitle(f"{self.name}: how precise must a chip be?", fontsize=13)
        for number, (kind, axes) in enumerate(zip(get_args(Kind), figure.subplots(1, 3), strict=True)):
            self._draw(axes, kind).set_ylabel("wrong cells [%]" if number == 0 else "")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=8)
        figure.text(0.995, 0.005, f"shares of {self.judged_on}; seed {self.seed}", ha="right", va="bottom", fontsize=8)
        return figure

    def _repr_png_(self) -> bytes:
        file = BytesIO()
        self.figure().savefig(file, format="png", dpi=90)
        return file.getvalue()

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import facts, heading, image

        name = heading("Robustness", f"{self.name}, judged on {self.judged_on}")
        return name + facts(dict(self.rows())) + image(self._repr_png_())


def _until_wrong(shares: tuple[float, ...]) -> Iterable[float]:
    for share in shares:
        if share > 0:
            return
        yield share


def _level(level: float | None, scale: float, unit: str) -> str:
    return "none" if level is None else f"up to {scale * level:g}{unit}"


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


def draw_robustness(found: Robustness, path: str | Path) -> None:
    """Write the three curves; the format follows the name's ending.

    Raises:
        InputError: the file cannot be written.
    """
    with writing(path) as temporary:
        found.figure().savefig(temporary, dpi=120)
