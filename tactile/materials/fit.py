"""Fit of the feature space and the known windows, by scikit-learn."""

import importlib
from dataclasses import replace
from types import ModuleType

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from cnnsim.support.extras import install_line
from tactile.materials.features import Kind
from tactile.materials.nearest_neighbours import KnownWindows, Space

LANDMARKS = 600
"""Number of windows with kernels; half as many cost 0.01 of the accuracy."""
WIDTH = 0.25
"""Exponent of the kernels at a mean squared distance of 1 in each scaled feature."""
WEIGHT = 4.0
"""Weight of the kernel features relative to the scaled ones."""
SHRINKAGE = 0.2
"""Shrinkage of the covariance to a multiple of the identity, times features over windows; 0.02 for 8000 windows."""


def learner(module: str) -> ModuleType:
    """Import a part of scikit-learn.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module(f"sklearn.{module}")
    except ModuleNotFoundError as error:
        raise InputError(
            f"learning textures needs scikit-learn, which is not installed: {install_line('texture')}"
        ) from error


def fit(values: Floats, material: Integers, count: int, kind: Kind) -> tuple[Space, KnownWindows]:
    """Return the space and the known windows of features (n, k) with materials (n,), numbers below ``count``.

    The two figures are only scaled. The full set gets kernels to a fixed random choice of windows, and is projected to
    the discriminants of the materials.
    """
    centre, spread = values.mean(0), values.std(0)
    scale = np.where(spread > 0, spread, 1.0)
    size = values.shape[1]
    space = Space(centre, scale, np.empty((0, size)), np.empty((0, 0)), WIDTH / size, WEIGHT, np.eye(size))
    if kind == "full" and len(np.unique(material)) > 1:
        # threads of linear algebra on a busy processor cost ten times what they save
        with importlib.import_module("threadpoolctl").threadpool_limits(1, "blas"):  # a dependency of scikit-learn
            space = _turned(space, (values - centre) / scale, material)
    return space, KnownWindows(space(values), material, count)


def _turned(space: Space, scaled: Floats, material: Integers) -> Space:
    """Return the space with kernels to some of the scaled windows, projected to their discriminants."""
    kernels = learner("kernel_approximation").Nystroem(
        gamma=space.gamma, n_components=min(LANDMARKS, len(scaled) // 2), random_state=0
    )
    kernels.fit(scaled)
    space = replace(space, landmarks=kernels.components_, root=kernels.normalization_)
    joined = space.joined(scaled)
    shrinkage = min(SHRINKAGE * joined.shape[1] / len(joined), 1.0)
    discriminant = learner("discriminant_analysis").LinearDiscriminantAnalysis(solver="eigen", shrinkage=shrinkage)
    discriminant.fit(joined, material)
    most = min(len(np.unique(material)) - 1, len(discriminant.scalings_))
    return replace(space, projection=np.ascontiguousarray(discriminant.scalings_[:, :most]))
