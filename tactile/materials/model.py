"""Texture model: features, feature space, known windows, and confidence of a prediction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.materials.conditions import conditions_of
from tactile.materials.features import FeatureSet
from tactile.materials.fit import fit, learner
from tactile.materials.nearest_neighbours import KnownWindows, Space
from tactile.materials.novelty import StandOut, numbered, stand_out
from tactile.materials.slide import Slide
from tactile.materials.windows import WindowTable, cut

OVERLAP = 4
"""Overlap of training windows: a window every quarter of its length (full set), or adjacent windows (two figures)."""


@dataclass(frozen=True)
class Confidence:
    """Probability that the predicted material is right, from the vote share s and the novelty d of a window.

        p = 1 / (1 + exp(-(offset + vote log(s / (1 - s)) + distance log d)))

    Fitted to held-out windows, with each material left out in turn; all unknown ones together weigh as much as one
    known material.
    """

    offset: float
    vote: float
    distance: float

    def __call__(self, share: Floats, novelty: Floats) -> Floats:
        """Return the probabilities (n,)."""
        told = self.offset + np.column_stack(_evidence(share, novelty)) @ (self.vote, self.distance)
        sure: Floats = 1 / (1 + np.exp(-np.clip(told, -500, 500)))
        return sure


@dataclass(frozen=True)
class TextureModel:
    """A classifier of ``materials``: ``features`` of windows, their ``space``, the ``known`` windows in it.

    ``confidence`` of a prediction; ``conditions``: recording conditions of the training slides, as plain data.
    """

    materials: tuple[str, ...]
    features: FeatureSet
    space: Space
    known: KnownWindows
    confidence: Confidence
    conditions: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"TextureModel({', '.join(self.materials)}; {self.features.kind}, {len(self.known.places)} windows)"

    def tell(self, table: WindowTable) -> tuple[Floats, Floats]:
        """Return the vote shares (n, materials) of windows (n,), and the confidence (n,) of the largest."""
        vote = self.known.vote(self.space(table.values))
        return vote.shares, self.confidence(vote.share, vote.novelty)


def hop(features: FeatureSet) -> int:
    """Return after how many samples the next window to learn from begins."""
    return features.window if features.kind == "figures" else max(features.window // OVERLAP, 1)


def train(slides: Sequence[Slide], features: FeatureSet) -> tuple[TextureModel, dict[str, float]]:
    """Train on slides; return the model, and for each material the AUROC of its novelty when it is left out.

    Raises:
        InputError: slides without a material, fewer than two materials, fewer than two slides of one; no scikit-learn.
    """
    learner("neighbors")  # fails before the work
    table = cut(slides, features, hop(features))
    materials, numbers = numbered(table)
    stands = stand_out(table, features.kind, features.window)
    space, known = fit(table.values, numbers, len(materials), features.kind)
    conditions = conditions_of(table, features.window)
    model = TextureModel(materials, features, space, known, _confidence(stands, len(materials)), conditions)
    return model, stands.auroc(materials)


def _confidence(stands: StandOut, materials: int) -> Confidence:
    if not stands.right.any() or stands.right.all():  # with two materials none can be left out
        return Confidence(0.0, 1.0, 0.0)
    counts = np.where(stands.unknown, 1 / max(stands.unknown.sum(), 1), materials / max((~stands.unknown).sum(), 1))
    evidence = np.column_stack(_evidence(stands.share, stands.novelty))
    fitted = learner("linear_model").LogisticRegression().fit(evidence, stands.right, counts * len(counts))
    vote, distance = fitted.coef_[0].tolist()
    return Confidence(float(fitted.intercept_[0]), vote, distance)


def _evidence(share: Floats, novelty: Floats) -> tuple[Floats, Floats]:
    bounded = np.clip(share, 0.01, 0.99)  # the resolution of 31 votes
    return np.log(bounded / (1 - bounded)), np.log(np.maximum(novelty, 1e-6))
