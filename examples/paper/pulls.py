"""The paper's texture bench (sect. 6): four materials pulled over four bumps in all directions, 15 ms a frame, T = 128.

The object lies on all four bumps. One taxel is read, and its strains are used as they are.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from examples.paper.bump import RUBBER, SENSOR
from tactile.core.frame import TaxelArray
from tactile.simulator.bump_cover import Bumps
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.scene.scene import Scene
from tactile.texture.figures import Texture

FRAME, WINDOW = 15e-3, 128
"""Duration of a frame [s], and frames of a point, as in the paper."""
PULLS, POINTS = 6, 125
"""Pulls of a material and points of a pull: 3000 points in total, as in Fig. 15."""
LONGEST = 600
"""Most frames of a pull: when the rasp leaves the skin, friction is undefined and the T frames start again."""
BEGIN = 20
"""Frames until the shear has built up and the object slides."""
ARRAY = TaxelArray("finger", 2, 2, 1.5e-3, SENSOR)
BUMPS = Bumps(indentation=120e-6)
"""Finite strain up to 25 mN a bump."""
FORCES = 4e-3, 40e-3
"""Range of the mean force [N] of a pull, on all four bumps: a bump under the rasp's teeth takes up to 22 mN."""
NOISE, FULL_SCALE = 5e-4, 0.1


@dataclass(frozen=True)
class Pull:
    """One pull: its parameters, the mean ``friction`` of its forces, the strains (n, 3) of one taxel, and friction and
    roughness (m, 2) of these strains.
    """

    material: str
    speed: float
    direction: float
    force: float
    friction: float
    strains: NDArray[np.float64]
    points: NDArray[np.float64]


def pull(material: str, seed: int) -> Pull:
    """Pull a material once: random direction, 4 to 6 mm/s, a mean force of 4 to 40 mN."""
    random = np.random.default_rng((sum(map(ord, material)), seed))
    direction, speed, force = random.uniform(0, 2 * np.pi), random.uniform(4e-3, 6e-3), random.uniform(*FORCES)
    stiffness = 4 * BUMPS.response(ARRAY, "strain").stiffness[1] * RUBBER.modulus
    drawn = SlidingTexture(
        0, (0.0, 0.0), PRESETS[material], 0.0, LONGEST * FRAME, speed, direction, force, float(stiffness), seed
    )
    scene = Scene(
        material, 1 / FRAME, LONGEST * FRAME, RUBBER.modulus, (ARRAY,), (), (drawn,), (ReadNoise(NOISE),),
        FULL_SCALE, seed, BUMPS,
    )  # fmt: skip
    texture, rows, points = Texture(WINDOW, 5 * NOISE * FULL_SCALE), [], []
    for frame in scene:
        rows.append(frame.values[0, 0])
        if frame.sequence >= BEGIN:
            figures = texture.update(frame.values[:1, :1])
            if figures.valid[0, 0]:
                points.append((figures.friction[0, 0], figures.roughness[0, 0]))
        if len(points) == POINTS:
            break
    shear, normal = drawn.series(np.arange(BEGIN, len(rows), dtype=np.float64) * FRAME)
    friction = float(np.mean(shear[normal > 0] / normal[normal > 0]))
    return Pull(material, speed, direction, force, friction, np.array(rows), np.reshape(points, (-1, 2)))


@cache
def all_pulls() -> tuple[Pull, ...]:
    """Return all pulls of all materials."""
    return tuple(pull(material, seed) for material in PRESETS for seed in range(PULLS))
