"""Novelty of unknown materials: each is left out of the training in turn, and its distance is measured."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Flags, Floats, InputError, Integers
from cnnsim.support.progress import watcher
from tactile.materials.features import Kind
from tactile.materials.fit import fit, learner
from tactile.materials.split import by_slide
from tactile.materials.windows import WindowTable


def numbered(table: WindowTable) -> tuple[tuple[str, ...], Integers]:
    """Return the materials in order, and the number of each window's material.

    Raises:
        InputError: windows without a material, fewer than two materials, or one with fewer than two slides.
    """
    found = table.material
    materials = sorted(set(found.tolist()), key=lambda one: (not one.isdigit(), int(one) if one.isdigit() else 0, one))
    if "" in materials:
        first = table.slides[int(table.slide[np.flatnonzero(found == "")[0]])].name
        raise InputError(f"slide {first}: no material; labels, or a folder for each material, wanted")
    few = [one for one in materials if len(set(table.slide[found == one])) < 2]
    if len(materials) < 2 or few:
        said = f"1 slide with windows of {', '.join(few)}" if few else f"materials {', '.join(materials)}"
        raise InputError(f"{said}; at least two materials with two slides each wanted")
    return tuple(materials), np.array([materials.index(one) for one in found])


@dataclass(frozen=True)
class StandOut:
    """Held-out windows: ``left_out`` (n,) number of the material that was left out.

    ``unknown`` (n,) whether the window is of it; ``share``, ``novelty`` of its vote; ``right`` whether the predicted
    material is right.
    """

    left_out: Integers
    unknown: Flags
    share: Floats
    novelty: Floats
    right: Flags

    def auroc(self, materials: tuple[str, ...]) -> dict[str, float]:
        """Return for each material the AUROC of the distance of its windows against known ones."""
        score = learner("metrics").roc_auc_score
        out = {}
        for number in sorted(set(self.left_out.tolist())):
            mine = self.left_out == number
            out[materials[number]] = float(score(self.unknown[mine], self.novelty[mine]))
        return out


def stand_out(table: WindowTable, kind: Kind, window: int) -> StandOut:
    """Leave each material out in turn, train on four fifths of the other slides, and test on it and the other fifth."""
    materials, numbers = numbered(table)
    folds = list(by_slide(table, window))
    rows, watch = [], watcher()
    for out in range(len(materials) if len(materials) > 2 else 0):
        if watch is not None:
            watch(out / len(materials), f"{kind}: {materials[out]} left out")
        train, test = folds[out % len(folds)]
        train = train[numbers[train] != out]
        every = np.concatenate([other.test for other in folds])
        test = np.concatenate([test[numbers[test] != out], every[numbers[every] == out]])
        space, near = fit(table.values[train], numbers[train], len(materials), kind)
        vote = near.vote(space(table.values[test]))
        right = vote.material == numbers[test]
        rows.append((np.full(test.size, out), numbers[test] == out, vote.share, vote.novelty, right))
    if not rows:
        nothing = np.empty(0)
        return StandOut(nothing.astype(int), nothing.astype(bool), nothing, nothing, nothing.astype(bool))
    return StandOut(*(np.concatenate(column) for column in zip(*rows, strict=True)))
