"""Slides over the simulator's materials, and files of them."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.materials.slide import Slide
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.sliding_texture import SlidingTexture

RATE = 100.0
NOISE = 2e-3
"""[N] of each component."""


def slide(material: str, seed: int, samples: int = 400, speed: float = 5e-3, rate: float = RATE) -> Slide:
    """Return one slide with jittered times, noise, and shear mostly along x."""
    random = np.random.default_rng(seed)
    t = (np.arange(samples) + random.uniform(-0.2, 0.2, samples)) / rate + 0.5
    made = SlidingTexture(0, (0.0, 0.0), PRESETS[material], 0.0, t[-1] + 1, speed, 0.3, 0.3, 1000.0, seed)
    shear, normal = made.series(t)
    force = np.column_stack([shear * np.cos(0.3), shear * np.sin(0.3), normal])
    return Slide(f"{material} {seed}", t, force + random.normal(0, NOISE, force.shape), material, seed % 4)


def slides(count: int, materials: tuple[str, ...] = tuple(PRESETS), samples: int = 400) -> list[Slide]:
    """Return `count` slides over each material."""
    return [slide(name, 100 * n + k, samples) for n, name in enumerate(materials) for k in range(count)]


def write_slides(path: Path, made: list[Slide], axes: tuple[int, int, int] | None = None) -> None:
    """Write a file of slides; ``axes`` are the columns of shear_x, shear_y and normal."""
    force: Floats = np.concatenate([one.force for one in made])
    extra: dict[str, Any] = {}
    if axes is not None:
        turned = np.empty_like(force)
        turned[:, list(axes)] = force
        force, extra = turned, {"axes": np.array(axes)}
    np.savez(
        path, force=force, length=np.array([one.t.size for one in made]), t=np.concatenate([one.t for one in made]),
        material=np.array([one.material for one in made]), **extra,
    )  # fmt: skip
