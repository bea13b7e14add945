"""The paper's texture bench (sect. 6): four materials pulled over the skin in all directions, 15 ms a frame, T = 128.

The load located by four taxels under a flat cover replaces the signals of one taxel under a bump: both separate normal
force and shear.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tactile.core.frame import TaxelArray
from tactile.finger import Finger
from tactile.settings import Settings
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
ARRAY = TaxelArray("finger", 2, 2, 1.5e-3, 1.5e-3)


@dataclass(frozen=True)
class Pull:
    """One pull: its parameters, the located load (n, 3) of Q, R, F [N], and friction and roughness (m, 2)."""

    material: str
    speed: float
    direction: float
    force: float
    load: NDArray[np.float64]
    points: NDArray[np.float64]


def pull(material: str, seed: int) -> Pull:
    """Pull a material once: random direction, 4 to 6 mm/s, a mean force of 0.15 to 0.6 N."""
    random = np.random.default_rng((sum(map(ord, material)), seed))
    direction, speed, force = random.uniform(0, 2 * np.pi), random.uniform(4e-3, 6e-3), random.uniform(0.15, 0.6)
    drawn = SlidingTexture(0, (0.0, 0.0), PRESETS[material], 0.0, LONGEST * FRAME, speed, direction, force, 1e3, seed)
    noise = ("read_noise", ReadNoise(5e-4))
    scene = Scene(material, 1 / FRAME, LONGEST * FRAME, 0.87e6, (ARRAY,), (), (drawn,), (noise,), seed=seed)
    finger, texture, rows, points = Finger(ARRAY, scene.modulus, Settings()), Texture(WINDOW, 0.0), [], []
    for frame in scene:
        load = finger.locate(frame)
        assert load is not None
        row = np.nan_to_num(np.array([load.Q, load.R, load.F]))
        rows.append(row)
        if frame.sequence >= BEGIN:
            figures = texture.update(row[None, None])
            if figures.valid[0, 0]:
                points.append((figures.friction[0, 0], figures.roughness[0, 0]))
        if len(points) == POINTS:
            break
    return Pull(material, speed, direction, force, np.array(rows), np.reshape(points, (-1, 2)))


@cache
def all_pulls() -> tuple[Pull, ...]:
    """Return all pulls of all materials."""
    return tuple(pull(material, seed) for material in PRESETS for seed in range(PULLS))
