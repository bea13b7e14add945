"""Materials of sliding textures: profile along the path, and friction."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats, InputError


@dataclass(frozen=True)
class Material:
    """A textured surface.

    Arguments: ``period`` [m] of its regular structure and ``regular``, how much of the normal force follows it
    (1 sigma over the mean); ``grain`` [m], the shortest length of its irregular structure, up to thirty times as
    long, and ``irregular`` likewise; ``sharpness``, 0 for waves, up to 1 for teeth; ``static`` and ``kinetic``
    friction coefficients.

    Raises:
        InputError: lengths that are not positive, negative shares, static friction below kinetic.
    """

    name: str
    period: float
    regular: float
    grain: float
    irregular: float
    sharpness: float
    static: float
    kinetic: float

    def __post_init__(self) -> None:
        if not (self.period > 0 and self.grain > 0 and self.regular >= 0 and self.irregular >= 0):
            raise InputError(f"material {self.name!r}: lengths that are positive and shares from 0 up wanted")
        if not (0 <= self.kinetic <= self.static and 0 <= self.sharpness <= 1):
            raise InputError(f"material {self.name!r}: 0 <= kinetic <= static friction and 0 <= sharpness <= 1 wanted")

    def profile(self, path: Floats, random: np.random.Generator) -> Floats:
        """Return the profile along the path [m] relative to the mean normal force, of mean 0 and the stated deviation.

        The regular part is a wave that sharpness turns into teeth; the irregular one is a sum of 48 waves, their
        lengths spread evenly in the logarithm.
        """
        phase = 2 * np.pi * (path / self.period + random.uniform())
        teeth = 2 * np.arctan2(self.sharpness * np.sin(phase), 1 - self.sharpness * np.cos(phase))
        # mean square of the series 2 sum s^n sin(n phase) / n
        n = np.arange(1, 400)
        power = 2 * np.sum(self.sharpness ** (2 * n) / n**2)
        regular = teeth / np.sqrt(power) if self.sharpness > 0 else np.sqrt(2) * np.sin(phase)
        lengths = self.grain * 30 ** random.uniform(0, 1, 48)
        turns = random.uniform(0, 2 * np.pi, 48)
        irregular = np.zeros_like(path)
        for length, turn in zip(lengths, turns, strict=True):
            irregular += np.sin(2 * np.pi * path / length + turn)
        height: Floats = self.regular * regular + self.irregular * irregular / np.sqrt(24)
        return height


PRESETS = {
    material.name: material
    for material in (
        Material("screw", 0.5e-3, 0.35, 0.2e-3, 0.05, 0.6, 0.45, 0.35),
        Material("smooth wood", 4e-3, 0.03, 0.3e-3, 0.06, 0.0, 0.55, 0.48),
        Material("fine textile", 0.35e-3, 0.12, 0.15e-3, 0.10, 0.2, 0.95, 0.75),
        Material("rasp", 1.6e-3, 0.45, 0.3e-3, 0.20, 0.85, 1.15, 0.70),
    )
}
"""The paper's four materials (sect. 6, Fig. 14). The paper gives no numbers: a thread of 0.5 mm, a fine weave, planed
wood and a rasp's teeth were given the lengths such things have, and friction in the order rubber shows on them."""
