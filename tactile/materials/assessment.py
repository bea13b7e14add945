"""Assessment of texture classification: cross-validation by slide, block and place, and unknown materials."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.support import Integers
from cnnsim.support.progress import watcher
from tactile.materials.features import Kind
from tactile.materials.fit import fit
from tactile.materials.novelty import numbered, stand_out
from tactile.materials.split import Split, by_block, by_place, by_slide
from tactile.materials.windows import WindowTable


@dataclass(frozen=True)
class Assessment:
    """Accuracy of the windows under several splits, and the separation of unknown materials.

    ``by_slide``, ``by_block``, ``by_place``: None without such groups; ``unknown``: for each material the AUROC of the
    distance of its windows from all known windows, when it is left out of the training, against windows of held-out
    slides of the known materials; ``confusion`` (materials, materials): true by predicted, by block, or else by slide;
    ``grouped`` names the split.
    """

    kind: Kind
    materials: tuple[str, ...]
    by_slide: float
    by_block: float | None
    by_place: float | None
    unknown: dict[str, float]
    confusion: Integers
    grouped: str

    @property
    def auroc(self) -> float | None:
        """Mean over the materials."""
        return float(np.mean(list(self.unknown.values()))) if self.unknown else None

    def plain(self) -> dict[str, Any]:
        """Return all as plain data."""
        worst = min(self.unknown, key=lambda one: self.unknown[one], default=None)
        return {
            "features": self.kind, "by_slide": self.by_slide, "by_block": self.by_block, "other_place": self.by_place,
            "unknown_auroc": self.auroc, "unknown_auroc_least": None if worst is None else self.unknown[worst],
            "unknown_auroc_by_material": self.unknown, "chance": 1 / len(self.materials), "materials": self.materials,
            "confusion": self.confusion.tolist(), "confusion_grouped_by": self.grouped,
        }  # fmt: skip


def assess(table: WindowTable, kind: Kind, window: int) -> Assessment:
    """Train and test for each split of the windows.

    Raises:
        InputError: windows without a material, fewer than two materials, or a material with fewer than two slides.
    """
    materials, numbers = numbered(table)
    told: dict[str, tuple[Integers, Integers]] = {}
    for name, splits in (("slide", by_slide), ("block", by_block), ("place", by_place)):
        told[name] = _told(table, numbers, len(materials), kind, splits(table, window), f"{kind}: by {name}")
    shares = {name: float((known == said).mean()) if known.size else None for name, (known, said) in told.items()}
    grouped = "block" if shares["block"] is not None else "slide"
    confusion = np.zeros((len(materials), len(materials)), np.int64)
    np.add.at(confusion, told[grouped], 1)
    stands = stand_out(table, kind, window)
    return Assessment(
        kind, materials, shares["slide"] or 0.0, shares["block"], shares["place"], stands.auroc(materials), confusion,
        grouped,
    )  # fmt: skip


def _told(
    table: WindowTable, numbers: Integers, count: int, kind: Kind, splits: Iterable[Split], doing: str
) -> tuple[Integers, Integers]:
    """Return the true and the predicted material of all tested windows."""
    known, said, watch = [np.empty(0, np.int64)], [np.empty(0, np.int64)], watcher()
    for train, test in splits:
        if watch is not None:
            watch(None, doing)
        space, near = fit(table.values[train], numbers[train], count, kind)
        known.append(numbers[test])
        said.append(near.vote(space(table.values[test])).material)
    return np.concatenate(known), np.concatenate(said)
