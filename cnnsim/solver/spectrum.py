"""Spectrum of I - A: its inverse on a grid by fast sine, cosine or Fourier transforms, and its definiteness."""

from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np

from cnnsim.network import Boundary, Tap
from cnnsim.support import Floats

Inverse = Callable[[Floats], Floats]


def spectral_inverse(taps: tuple[Tap, ...], shape: tuple[int, int], boundary: Boundary) -> Inverse:
    """Return v -> (I - A)^-1 v of planes in one row (cells,).

    Sines vanish on virtual cells of output 0, cosines repeat themselves beyond an edge, a torus has Fourier's waves;
    (I - A) times such a wave is 1 - sum A(k, l) cos(k p) cos(l q) times it. That is exact for a symmetric A of radius
    1, and near enough for `scipy.sparse.linalg.cg` else. Waves that A does not change are not changed.
    """
    p, q = (_frequencies(n, boundary) for n in shape)

    @cache
    def sizes() -> Floats:
        size = 1.0 - sum(weight * np.cos(k * p)[:, None] * np.cos(l * q)[None] for k, l, weight in taps)
        return np.where(np.abs(size) < 1e-12 * np.abs(size).max(), 1.0, size)

    def inverse(v: Floats) -> Floats:
        from scipy import fft  # slow to import, and only needed where a large grid is solved

        plane, size = v.reshape(shape), sizes()
        if boundary.kind == "periodic":
            found = fft.ifft2(fft.fft2(plane) / size).real
        elif boundary.kind == "zero-flux":
            found = fft.idctn(fft.dctn(plane, type=2) / size, type=2)
        else:
            found = fft.idstn(fft.dstn(plane, type=1) / size, type=1)
        return np.asarray(found).ravel()

    return inverse


def _frequencies(cells: int, boundary: Boundary) -> Floats:
    if boundary.kind == "periodic":
        return 2 * np.pi * np.arange(cells) / cells
    if boundary.kind == "zero-flux":
        return np.pi * np.arange(cells) / cells
    return np.pi * (np.arange(cells) + 1) / (cells + 1)


@lru_cache(maxsize=64)
def is_definite(taps: tuple[Tap, ...], boundary: Boundary, *, decay: float = 0.0) -> bool:
    """Return whether all modes of I - A, among any cells of any grid, decay at least at the rate ``decay``.

    For a symmetric A the matrix among some cells is a part of that of the endless grid, whose modes are the waves: its
    smallest mode is at least that of the smallest wave (Cauchy's interlacing). Cells repeated beyond an edge are a
    mirror only for radius 1 and an A that is the same in the mirror.
    """
    weights = {(k, l): weight for k, l, weight in taps}
    if any(weights.get((-k, -l)) != weight for (k, l), weight in weights.items()):
        return False
    if boundary.kind == "reflecting":  # whose matrix is not symmetric
        return False
    if boundary.kind == "zero-flux" and any(
        max(abs(k), abs(l)) > 1 or weights.get((-k, l)) != weight for (k, l), weight in weights.items()
    ):
        return False
    p = np.linspace(-np.pi, np.pi, 257)
    size = 1.0 - sum(weight * np.cos(k * p[:, None] + l * p) for k, l, weight in taps)
    return bool(np.min(size) >= decay - 1e-12 * np.max(np.abs(size)))
