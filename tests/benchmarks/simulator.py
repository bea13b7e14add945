"""The simulator: frames of a moving load, what effects cost, and two ways to sum loads."""

from collections.abc import Callable

import numpy as np

from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct import direct_sum
from tactile.elastic.sums.spectral import TractionTransform
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.scene.scene import Scene
from tests.benchmarks.race import Row, race

ARRAY = TaxelArray("a", 8, 8, 1e-3, 1e-3)
PATH = np.array([(0.0, -4e-3, 0, 0.01, 0, 0.1), (100.0, 4e-3, 1e-3, 0, 0.02, 0.2)])
BARE = Scene("moving load", 1000.0, 100.0, 2.4e6, (ARRAY,), (MovingLoad(0, PATH),))
BODY, PAIRS = Medium(1.0), (100_000, 1024)
SIDE = 256


def everything(scene: Scene) -> Callable[[], object]:
    """Compute all frames of a scene and keep none."""
    return lambda: [None for _ in scene.batches(0)]


def frames(rounds: int) -> list[Row]:
    """100 000 frames of 8 x 8 taxels under a moving load, without and with a noise effect."""
    scenes = {"bare": BARE, "one noise effect": BARE.with_effects([("read_noise", ReadNoise())])}
    best = race({name: everything(scene) for name, scene in scenes.items()}, 3 * rounds)
    targets = {"bare": ">= 200 kHz", "one noise effect": "<= 1.5 x the time"}
    rows = []
    for name, seconds in best.items():
        ratios = {} if name == "bare" else {"bare": best["bare"] / seconds}
        note = "" if name == "bare" else f"{seconds / best['bare']:.3f} x the time of bare"
        rate = 1e-3 * BARE.samples / seconds
        rows.append(Row(f"8x8, moving load, {name}", "cpu", rate, "kHz", targets.get(name, ""), ratios, note))
    return rows


def summation(rounds: int) -> list[Row]:
    """The direct sum, and the sum by transforms."""
    random = np.random.default_rng(0)
    loads, at = random.normal(size=(1, PAIRS[0], 5)), random.normal(size=(PAIRS[1], 2))
    traction = random.normal(size=(SIDE, SIDE, 3))
    transforms = TractionTransform((SIDE, SIDE), (SIDE, SIDE), 1.0, 1.0, Medium(1.0, 0.499))
    runners: dict[str, Callable[[], object]] = {
        "direct": lambda: direct_sum(at, 0.5, loads, BODY),
        "transforms": lambda: transforms(traction),
    }
    best = race(runners, rounds)
    pairs = 1e-9 * PAIRS[0] * PAIRS[1] / best["direct"]
    return [
        Row("1024 taxels, 1e5 loads, direct sum", "cpu", pairs, "G pairs/s", ">= 0.3"),
        Row(f"{SIDE}x{SIDE} loads and taxels, transforms", "cpu", 1 / best["transforms"], "Hz"),
    ]
