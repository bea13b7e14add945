"""A grid with a template that mixes its neighbours, and runs of it in supersteps by one worker."""

from typing import Any

import numpy as np

from cnnsim.network import Template
from cnnsim.supersteps.engine import Engine

RANDOM = np.random.default_rng(5)
SHAPE = (37, 45)
MIXED = Template(
    [[0.1, 0.3, 0.1], [0.2, 1.5, 0.2], [0.1, 0.3, 0.1]], [[0, 0.2, 0], [0.1, 1, 0.1], [0, 0.2, 0]], -0.05, "mixed"
)
X, U, BIAS, MASK = (RANDOM.uniform(-1, 1, SHAPE) for _ in range(4))


def one(**choices: Any) -> Engine:
    return Engine(workers=1, **choices)
