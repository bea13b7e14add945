"""Simulated skins of Figs. 7 and 8, with the paper's errors one at a time and together, and their trials."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from examples.paper.needle import BODY, DEPTH, NOISE, SECTION_4_1, SPEED, Effects, Located, Scan, locate, scan, typical
from tactile.calibration.gains import Gains
from tactile.calibration.sensitivity import beta_from_scan
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.taxel_area import TaxelArea

LINES = np.linspace(-250e-6, 250e-6, 11)
FAR = (200e-6, 250e-6)
"""[m] Ring "far from the center"."""
Measured = Literal["strain", "stress"]


@dataclass(frozen=True)
class Skin:
    """A cover with its taxel: active effects, and the quantity that the taxel measures."""

    name: str
    effects: Effects
    quantity: Measured = "strain"


def but(*left_out: str) -> Effects:
    """Return the effects of the paper's list except some."""
    return typical(*(name for name in SECTION_4_1 if name not in left_out))


ALL = Skin("all of sect. 4.1", but())
POINT = Skin("all but the taxel's area", but("taxel_area"))
STRESS = Skin("measures stress", (), "stress")
SKINS = (
    Skin("ideal", ()),
    *(Skin(name.replace("_", " "), typical(name)) for name in SECTION_4_1),
    Skin("taxel 100 um wide", (("taxel_area", TaxelArea(100e-6)),)),
    Skin("layer 1.5 z thick", (("finite_thickness", FiniteThickness(1.5 * DEPTH)),)),
    STRESS,
    Skin("measures stress at a layer's bottom", (("finite_thickness", FiniteThickness(DEPTH)),), "stress"),
    Skin("all noise", typical(*NOISE)),
    Skin("all of the body", typical(*BODY)),
    POINT,
    ALL,
)
COVERS = (1, 1.5, 2, 3, 5)
"""Thicknesses of the cover [depths of the taxels]. The paper's taxels lie at the cover's bottom: 1."""
THICK = ", ".join(f"{times:g}" for times in COVERS)


def covered(times: float, quantity: Measured = "strain") -> Skin:
    """Return the skin without the taxel's area under a cover of this thickness [depths]."""
    cover = {"finite_thickness": FiniteThickness(times * DEPTH)}
    effects = tuple((name, cover.get(name, effect)) for name, effect in POINT.effects)
    return Skin(f"{quantity}, {times:g} z thick", effects, quantity)


@dataclass(frozen=True)
class Trial:
    """Trial of a skin: beta_ns from its own centre line, the map with it, and the map with the corrected depth.

    ``beta``: 1 is true; ``speed`` [m/s] on the middle line of the map; ``needed``: beta_ns that fits the readings far
    from the centre, over ``beta``: above 1 ``beta`` is an underestimate there; ``bend``: located distance of the lines
    at +-200 um where they are 150-200 um from the centre line, over that on the centre line: above 1 they bend
    outwards, as with an underestimated beta_ns (Fig. 6), below 1 inwards.
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
    """Scan a skin like the paper: the centre line for beta_ns, then parallel lines over the receptive field."""
    centre = scan(effects=skin.effects, quantity=skin.quantity, half=500e-6).readings[0]
    beta = beta_from_scan(centre[:, 0], centre[:, 2]).beta
    made = scan(LINES, skin.effects, quantity=skin.quantity, seed=seed)
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
    """Return the beta_ns of trials, separated by commas."""
    return ", ".join(f"{trial.beta:.2f}" for trial in trials)


def under_covers() -> list[tuple[Measured, list[Trial]]]:
    """Return the trials under covers of all thicknesses, for each measured quantity."""
    quantities: tuple[Measured, ...] = "strain", "stress"
    return [(quantity, [on_the_bench(covered(times, quantity)) for times in COVERS]) for quantity in quantities]
