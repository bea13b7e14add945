"""The oracles' answers to all templates, and random pictures for them on small grids."""

import numpy as np

from tests.oracles import binary, gray, kinds
from tests.oracles.pictures import Picture

ANSWERS = {**binary.ANSWERS, **gray.ANSWERS, **kinds.ANSWERS}
SHAPES = [(1, 1), (1, 9), (9, 1), (2, 2), (5, 8), (11, 10)]


def shapes(backend: str) -> list[tuple[int, int]]:
    """Return the shapes of grids for a backend: OpenCL compiles each template for each, and its conformance tests
    have all shapes."""
    return SHAPES[-1:] if backend == "opencl" else SHAPES


def pictures(name: str, shape: tuple[int, int], number: int = 3) -> list[Picture]:
    """A sparse, a balanced and a dense random picture, always the same ones for one name and shape."""
    rng = np.random.default_rng([*name.encode(), *shape])
    return [rng.random(shape) < share for share in (0.3, 0.5, 0.75)[:number]]
