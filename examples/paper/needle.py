"""The paper's bench (sect. 4): a needle drawn in parallel lines over one taxel, with any of the errors of sect. 4.1."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats
from tactile.calibration.gains import Gains
from tactile.core.frame import TaxelArray
from tactile.inverse.taxel import invert_strain
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import effect_class
from tactile.simulator.scene.scene import Scene

DEPTH, MODULUS, FORCE, SPEED, RATE = 200e-6, 2.4e6, 0.02, 0.5e-3, 50.0
"""Cover thickness [m], Young's modulus [Pa], load [N], speed [m/s] and frame rate [Hz] of sect. 4."""
NEAR = 150e-6
"""[m] Radius within which the paper's answers are reliable ("approximately 150 um")."""
HALF = 300e-6
"""[m] Half-length of the lines."""
FULL_SCALE = 0.15
"""Full scale of the electronics [strain]; the needle causes 0.0995."""
NOISE = ("needle_vibration", "surface_waviness", "motor_noise", "read_noise")
"""Effects that change from frame to frame, at typical strengths, since the paper does not state them."""
BODY = ("poisson_ratio", "finite_tip", "finite_thickness", "taxel_area", "strain_nonlinearity")
"""Constant effects that the ideal skin omits."""
SECTION_4_1 = ("needle_vibration", "surface_waviness", *BODY, "motor_noise", "read_noise")
"""The paper's list in the order of their action, and the noise of the electronics."""

Effects = Sequence[tuple[str, Any]]


@dataclass(frozen=True)
class Scan:
    """Readings (lines, n, 3), with the true places (lines, n, 2) [m] relative to the taxel and times (lines, n) [s]."""

    times: Floats
    places: Floats
    readings: Floats

    def within(self, radius: float) -> NDArray[np.bool_]:
        """Return a mask of the frames with the needle within a radius [m] of the taxel."""
        return np.hypot(self.places[..., 0], self.places[..., 1]) <= radius * (1 + 1e-9)


@dataclass(frozen=True)
class Located:
    """Loads located by one taxel in a scan: places (lines, n, 2) [m] and forces (lines, n) [N]."""

    places: Floats
    force: Floats

    def speed(self, scan: Scan, radius: float = NEAR) -> float:
        """Return the slope [m/s] of the places along the middle line within a radius, as in Fig. 8."""
        line = len(scan.times) // 2
        use = scan.within(radius)[line]
        return float(np.polyfit(scan.times[line, use], self.places[line, use, 0], 1)[0])

    def error(self, scan: Scan, radius: float = NEAR) -> float:
        """Return the root mean square distance [m] from the true places within a radius."""
        off = (self.places - scan.places)[scan.within(radius)]
        return float(np.sqrt((off**2).sum(-1).mean()))


def typical(*names: str) -> Effects:
    """Return effects at their typical strengths."""
    return tuple((name, effect_class(name)()) for name in names)


def scan(
    lines: Sequence[float] | Floats = (0.0,),
    effects: Effects = (),
    *,
    quantity: Literal["strain", "stress"] = "strain",
    gains: Gains | None = None,
    seed: int = 0,
    half: float = HALF,
) -> Scan:
    """Draw the needle along x at every y of ``lines`` [m], from -``half`` to ``half``, one line after the other.

    ``gains`` of the sensor: T = u / alpha by eq. (15), both 1 by default; ``quantity``: the measured one, stress in
    units of the modulus.
    """
    per_line = round(2 * half / SPEED * RATE)
    path = np.array(
        [((n * (per_line + 1) + k) / RATE, x, y, 0, 0, FORCE)
         for n, y in enumerate(lines) for k, x in ((0, -half), (per_line, half))]
    )  # fmt: skip
    array = TaxelArray("taxel", 1, 1, 1.5e-3, DEPTH, quantity=quantity)
    samples = len(lines) * (per_line + 1)
    scene = Scene("needle", RATE, samples / RATE, MODULUS, (array,), (MovingLoad(0, path),), (), tuple(effects),
                  FULL_SCALE, seed)  # fmt: skip
    values = np.concatenate([batch.values for batch in scene.batches(0)])[:, 0, 0] / scene.unit(0)
    if gains is not None:
        values = values / (gains.shear, gains.shear, gains.normal)
    times = np.arange(samples) / RATE
    shape = len(lines), per_line + 1
    return Scan(times.reshape(shape), scene.loads_at(0, times)[:, 0, :2].reshape(*shape, 2), values.reshape(*shape, 3))


def locate(made: Scan, gains: Gains, depth: float = DEPTH) -> Located:
    """Return the loads by the paper's inverse of every reading."""
    x, y, z = np.moveaxis(gains(made.readings), -1, 0)
    dx, dy, force, _ = invert_strain(x, y, z, depth, MODULUS, 0.0, 1)
    return Located(np.stack([dx, dy], axis=-1), force)
