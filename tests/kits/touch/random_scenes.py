"""Random scenes: loads and bodies over small arrays, with any effect at any strength."""

from dataclasses import replace
from typing import Any, cast

import numpy as np

from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER, effect_class, without
from tactile.simulator.effects.crosstalk import Crosstalk
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.electronics.clipping import Clipping
from tactile.simulator.effects.electronics.low_pass import LowPass
from tactile.simulator.effects.electronics.multiplex_skew import MultiplexSkew
from tactile.simulator.effects.electronics.pink_noise import PinkNoise
from tactile.simulator.effects.electronics.taxel_mismatch import TaxelMismatch
from tactile.simulator.effects.electronics.temperature import Temperature
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.frame_timing import FrameTiming
from tactile.simulator.effects.hysteresis import Hysteresis
from tactile.simulator.effects.motor_noise import MotorNoise
from tactile.simulator.effects.mounting.cover_error import CoverError
from tactile.simulator.effects.mounting.curved_fingertip import CurvedFingertip
from tactile.simulator.effects.mounting.misplacement import Misplacement
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.strain_nonlinearity import StrainNonlinearity
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tactile.simulator.scene.scene import Scene
from tactile.simulator.sizes import Sample

QUIET = [(name, without(effect_class(name))) for name in ORDER]
"""Every effect at strength zero."""
CHIP = TaxelArray("chip", 2, 2, 4e-4, 2e-4)


def needle(*effects: tuple[str, Any], duration: float = 1.0, seed: int = 0) -> Scene:
    """Return a needle that slides over the chip, with these effects and all others at strength zero."""
    path = np.array([(0.0, -3e-4, 1e-4, 0.002, 0, 0.02), (duration, 3e-4, 0, -0.002, 0.001, 0.015)])
    chosen = dict(QUIET) | dict(effects)
    return Scene("n", 100.0, duration, 2.4e6, (CHIP,), (MovingLoad(0, path),), (), tuple(chosen.items()), 0.15, seed)


def random_scene(random: np.random.Generator) -> Scene:
    """Return a scene with random effects, from far below to far above a tolerance of 0.01, and a random load."""

    def some(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    effects: list[tuple[str, Any]] = [
        ("needle_vibration", NeedleVibration(some(1e-9, 3e-6), some(1e-9, 1e-6))),
        ("surface_waviness", SurfaceWaviness(some(1e-9, 2e-6), some(2e-4, 2e-3))),
        ("poisson_ratio", PoissonRatio(0.5 - some(1e-4, 0.4))),
        ("finite_tip", FiniteTip(some(2e-6, 1e-4))),
        ("finite_thickness", FiniteThickness(2e-4 * some(1.2, 50))),
        ("taxel_area", TaxelArea(some(5e-6, 3e-4))),
        ("strain_nonlinearity", StrainNonlinearity(some(1e-3, 1))),
        ("viscoelastic", Viscoelastic(((some(1e-4, 0.2), some(1e-2, 10)),))),
        ("hysteresis", Hysteresis(some(1e-3, 0.5), some(1e-2, 0.3))),
        ("crosstalk", Crosstalk(some(1e-4, 0.1), some(1e-4, 0.1))),
        ("motor_noise", MotorNoise(some(1e-5, 0.05))),
        ("drift", Drift(some(1e-5, 0.05), some(1e-5, 0.05))),
        ("read_noise", ReadNoise(some(1e-5, 0.02))),
        ("dead_taxels", DeadTaxels(some(1e-3, 0.1), some(1e-3, 0.1))),
        ("quantisation", Quantisation(int(random.integers(6, 17)), 2.0)),
        ("frame_timing", FrameTiming(some(1e-6, 1e-3), some(1e-5, 1e-2), some(1e-5, 1e-2))),
    ]
    built: list[tuple[str, Any]] = [
        ("cover_error", CoverError(some(1e-8, 3e-5), some(1e-5, 1e-2))),
        ("misplacement", Misplacement(some(1e-8, 3e-5), 0.0, some(1e-5, 3e-2), some(1e-5, 1e-2))),
        ("curved_fingertip", CurvedFingertip(some(5e-3, 10.0))),
        ("taxel_mismatch", TaxelMismatch(some(1e-5, 0.02), some(1e-5, 0.01), some(1e-5, 0.03))),
        ("temperature", Temperature(0.0, some(1e-2, 10.0), some(0.1, 100.0))),
        ("pink_noise", PinkNoise(some(1e-5, 0.01))),
        ("clipping", Clipping(some(0.1, 3.0))),
        ("low_pass", LowPass(some(1e-5, 1e-2))),
        ("multiplex_skew", MultiplexSkew(some(1e-7, 1e-4))),
    ]
    duration = some(0.3, 3.5)
    x, y = random.uniform(-4e-4, 4e-4, (2, 2))
    forces = [(*random.uniform(-5e-3, 5e-3, 2), some(1e-3, 0.03)) for _ in range(2)]
    path = np.array([(0.0, x[0], y[0], *forces[0]), (duration, x[1], y[1], *forces[1])])
    # a random half of the effects is on
    taken = [one for one in (*effects, *built) if random.random() < 0.5]
    chosen = dict(QUIET) | dict(taken if random.random() < 0.5 else effects)
    seed = int(random.integers(1000))
    return Scene("r", 50.0, duration, 2.4e6, (CHIP,), (MovingLoad(0, path),), (), tuple(chosen.items()), 0.15, seed)


def random_touch(random: np.random.Generator) -> Scene:
    """Return a random scene with one to three loads and bodies over 2 x 2 to 8 x 8 taxels."""
    scene, side = random_scene(random), int(random.choice([2, 4, 8]))
    depth = float(random.choice([2e-4, 5e-4, 1e-3, 1.5e-3]))
    pitch, scale, quantity = (
        depth * float(random.choice([1, 1.5, 2])),
        depth / 2e-4,
        str(random.choice(["strain", "stress"])),
    )
    array = TaxelArray("pad", side, side, pitch, depth, quantity=cast(Any, quantity))
    loads, bodies = list[MovingLoad](), list[MovingContact]()
    for _ in range(int(random.integers(1, 4))):
        path = np.zeros((4, 6))
        path[:, 0] = scene.duration * np.arange(4) / 3
        path[:, 1:3] = random.uniform(-1, 1, (4, 2)) * pitch * max(side - 1, 2) / 2
        path[:, 5] = np.exp(random.uniform(np.log(2e-3), np.log(0.02), 4)) * scale**2
        path[:, 3:5] = random.uniform(-0.3, 0.3, (4, 2)) * path[:, 5:]
        shape = str(random.choice(["load", "load", "sphere", "flat_punch", "needle"]))
        if shape == "load":
            loads.append(MovingLoad(0, path))
            continue
        low, high = {"sphere": (2, 5), "flat_punch": (0.3, 1.5), "needle": (1, 2)}[shape]
        path[:, 1:3] = path[0, 1:3]
        friction = float(random.uniform(0.3, 0.8)) if random.random() < 0.5 else None
        bodies.append(MovingContact(0, Indenter(cast(Any, shape), depth * random.uniform(low, high)), path, friction))
    effects = {name: effect for name, effect in scene.effects if not effect.off}
    if "finite_thickness" in effects:
        effects["finite_thickness"] = FiniteThickness(effects["finite_thickness"].thickness * scale)
    if "taxel_area" in effects:
        effects["taxel_area"] = TaxelArea(min(effects["taxel_area"].width * scale, pitch))
    return replace(scene, arrays=(array,), loads=tuple(loads), contacts=tuple(bodies), effects=tuple(effects.items()))


def error(one: Scene, other: Scene) -> float:
    """Return the largest difference of two scenes, linear in time between frames, relative to the ideal peak."""
    times, largest = np.arange(one.samples) / one.rate, 0.0
    for finger in range(len(one.arrays)):
        sides = []
        for scene in (one, other):
            batches = list(scene.batches(finger))
            t = np.concatenate([batch.t for batch in batches])
            read = np.concatenate([batch.values for batch in batches]).reshape(len(t), -1)
            t, first = np.unique(t, return_index=True)
            sides.append(np.stack([np.interp(times, t, column) for column in read[first].T]))
        largest = max(largest, float(np.abs(sides[0] - sides[1]).max()))
    return largest / Sample(one).peak


def error_of_seeds(chosen: Scene, whole: Scene, seeds: Any) -> float:
    """Return the largest error of a choice of effects over some seeds."""
    return max(error(replace(chosen, seed=seed), replace(whole, seed=seed)) for seed in seeds)
