"""A model of materials: the features, the space and the known windows, and how sure a told material is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.materials.conditions import conditions_of
from tactile.materials.features import FeatureSet
from tactile.materials.fit import fit, learner
from tactile.materials.nearest import Known, Space
from tactile.materials.slide import Slide
from tactile.materials.unknown import StandOut, numbered, stand_out
from tactile.materials.windows import WindowTable, cut

OVERLAP = 4
"""The full set is learned from windows that begin every quarter of one, the two figures from windows side by side."""


@dataclass(frozen=True)
class Confidence:
    """Probability that the told material is right, from the share of the votes s and the novelty d of a window.

        p = 1 / (1 + exp(-(offset + vote log(s / (1 - s)) + distance log d)))

    Fitted to windows that were not learned from, each material left out in turn; all unknown ones together count as
    much as one known material.
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
    """What ``materials`` feel like: ``features`` of windows, their ``space``, the ``known`` windows in it.

    ``confidence`` in what is told; ``conditions``: under which the slides were recorded, as plain data.
    """

    materials: tuple[str, ...]
    features: FeatureSet
    space: Space
    known: Known
    confidence: Confidence
    conditions: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"TextureModel({', '.join(self.materials)}; {self.features.kind}, {len(self.known.places)} windows)"

    def tell(self, table: WindowTable) -> tuple[Floats, Floats]:
        """Return of windows (n,) their shares of the votes (n, materials), and the confidence (n,) in the largest."""
        vote = self.known.vote(self.space(table.values))
        return vote.shares, self.confidence(vote.share, vote.novelty)


def hop(features: FeatureSet) -> int:
    """Return after how many samples the next window to learn from begins."""
    return features.window if features.kind == "figures" else max(features.window // OVERLAP, 1)


def train(slides: Sequence[Slide], features: FeatureSet) -> tuple[TextureModel, dict[str, float]]:
    """Learn from slides; return the model, and for each material how well it stands out where it is left out (AUROC).

    Raises:
        InputError: slides without a material, fewer than two materials, fewer than two slides of one; no scikit-learn.
    """
    learner("neighbors")  # said before the work
    table = cut(slides, features, hop(features))
    materials, numbers = numbered(table)
    stands = stand_out(table, features.kind, features.window)
    space, known = fit(table.values, numbers, len(materials), features.kind)
    conditions = conditions_of(table, features.window)
    model = TextureModel(materials, features, space, known, _confidence(stands, len(materials)), conditions)
    return model, stands.auroc(materials)


def _confidence(stands: StandOut, materials: int) -> Confidence:
    if not stands.right.any() or stands.right.all():  # two materials: nothing can be left out
        return Confidence(0.0, 1.0, 0.0)
    counts = np.where(stands.unknown, 1 / max(stands.unknown.sum(), 1), materials / max((~stands.unknown).sum(), 1))
    evidence = np.column_stack(_evidence(stands.share, stands.novelty))
    fitted = learner("linear_model").LogisticRegression().fit(evidence, stands.right, counts * len(counts))
    vote, distance = fitted.coef_[0].tolist()
    return Confidence(float(fitted.intercept_[0]), vote, distance)


def _evidence(share: Floats, novelty: Floats) -> tuple[Floats, Floats]:
    bounded = np.clip(share, 0.01, 0.99)  # 31 votes say no more
    return np.log(bounded / (1 - bounded)), np.log(np.maximum(novelty, 1e-6))
