"""The skins that Figs. 7 and 8 are asked of: the paper's list of errors, one at a time and together."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from examples.paper.needle import (
    BODY,
    DEPTH,
    NOISE,
    SECTION_4_1,
    SPEED,
    Effects,
    Located,
    Scan,
    locate,
    scan,
    typical,
)
from tactile.calibration.gains import Gains
from tactile.calibration.sensitivity import beta_from_scan
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.taxel_area import TaxelArea

LINES = np.linspace(-250e-6, 250e-6, 11)
FAR = (200e-6, 250e-6)
"""[m] Ring "far from the center"."""


Feels = Literal["strain", "stress"]


@dataclass(frozen=True)
class Skin:
    """A cover with its taxel: the effects that act, and what the taxel feels."""

    name: str
    effects: Effects
    feels: Feels = "strain"


def but(*left_out: str) -> Effects:
    """The paper's whole list without some of it."""
    return typical(*(name for name in SECTION_4_1 if name not in left_out))


ALL = Skin("all of sect. 4.1", but())
POINT = Skin("all but the taxel's area", but("taxel_area"))
STRESS = Skin("feels stress", (), "stress")
SKINS = (
    Skin("ideal", ()),
    *(Skin(name.replace("_", " "), typical(name)) for name in SECTION_4_1),
    Skin("taxel 100 um wide", (("taxel_area", TaxelArea(100e-6)),)),
    Skin("layer 1.5 z thick", (("finite_thickness", FiniteThickness(1.5 * DEPTH)),)),
    STRESS,
    Skin("feels stress at a layer's bottom", (("finite_thickness", FiniteThickness(DEPTH)),), "stress"),
    Skin("all noise", typical(*NOISE)),
    Skin("all of the body", typical(*BODY)),
    POINT,
    ALL,
)


THICK = (1, 1.5, 2, 3, 5)
"""Covers so many depths of the taxels thick. The paper's taxels lie at the cover's bottom: 1."""
FEELS: tuple[Feels, ...] = ("strain", "stress")


def covered(times: float, feels: Feels = "strain") -> Skin:
    """The skin without the taxel's area, its cover so many depths thick."""
    cover = {"finite_thickness": FiniteThickness(times * DEPTH)}
    return Skin(
        f"{feels}, {times:g} z thick", tuple((name, cover.get(name, effect)) for name, effect in POINT.effects), feels
    )


def spoken(values: Sequence[float]) -> str:
    """Numbers one after the other."""
    return ", ".join(f"{value:g}" for value in values)


@dataclass(frozen=True)
class Trial:
    """A skin on the bench: beta_ns from its own centre line, the map with that, and the map with the mended depth.

    ``beta``: 1 is true; ``speed`` [m/s] on the middle line of the map; ``needed``: beta_ns that the readings ask for
    far from the centre, over ``beta``: above 1 the map is there what an underestimated beta_ns would make it; ``bend``:
    how much farther out the lines at +-200 um are found 150-200 um beside the taxel than straight before it: above 1
    they bend outwards, as under an underestimated beta_ns (Fig. 6), below 1 inwards.
    """

    beta: float
    made: Scan
    located: Located
    speed: float
    depth: float
    mended: Located
    needed: float
    bend: float


@cache
def on_the_bench(skin: Skin, seed: int = 1) -> Trial:
    """Scan a skin as the paper does: the centre line for beta_ns, then parallel lines over the receptive field."""
    centre = scan(effects=skin.effects, feels=skin.feels, half=500e-6).readings[0]
    beta = beta_from_scan(centre[:, 0], centre[:, 2]).beta
    made = scan(LINES, skin.effects, feels=skin.feels, seed=seed)
    gains = Gains(beta, 1.0)
    located = locate(made, gains)
    depth = DEPTH * SPEED / located.speed(made)
    far = made.within(FAR[1]) & ~made.within(FAR[0])
    t = (made.places[far] ** 2).sum(-1) / DEPTH**2
    shear = np.hypot(made.readings[far][:, 0], made.readings[far][:, 1])
    needed = 3 * np.sqrt(t) / (2 - t) * np.abs(made.readings[far][:, 2]) / shear / beta
    mended = locate(made, gains, depth)
    x, y = np.moveaxis(np.abs(made.places), -1, 0)
    outer, out = np.abs(y - FAR[0]) < 1e-6, np.abs(located.places[..., 1])
    bend = float(np.median(out[outer & (x > 149e-6) & (x < 201e-6)]) / np.median(out[outer & (x < 26e-6)]))
    return Trial(beta, made, located, located.speed(made), depth, mended, float(np.median(needed)), bend)


def betas(trials: Sequence[Trial]) -> str:
    """The beta_ns of skins, one after the other."""
    return ", ".join(f"{trial.beta:.2f}" for trial in trials)
