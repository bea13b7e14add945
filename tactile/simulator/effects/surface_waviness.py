"""Surface waviness: a held needle meets hills and valleys of the cover."""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.altered import altered
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.held_needle import raised
from tactile.simulator.seen import sigmas
from tactile.simulator.slopes import Slopes

WAVES = 32


@effect("field", normal=True, price=(120, 1.8))
class SurfaceWaviness:
    """A random surface of standard deviation ``rms`` [m] over hills ``wavelength`` [m] apart.

    The height h(x, y) is a sum of 32 plane waves of random directions and phases, wavelengths within a factor 1.5 of
    ``wavelength``; mean 0 and deviation ``rms`` over the plane, the same surface for the whole scene. A held contact
    presses by h deeper, which its own law of force and indentation delta, on the cover as it is, turns into force:
    on the half-space (1 + h / delta)^1.5 times as hard for a sphere, 1 + h / delta for a flat end, Sneddon's law for a
    needle; a cylinder, and an edge of this ``tip_radius`` [m], go by ``lines.line_indentation``; on a layer all are
    stiffer, by ``layer_contact``. Loads at a point are held by a tip of ``tip_radius`` as by a sphere, under any force.
    Slopes are too small to turn the force.

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    rms: float = parameter(0.5e-6, key="rms_um", unit=1e-6, none=0.0)
    wavelength: float = parameter(1e-3, 1e-9, key="wavelength_mm", unit=1e-3)
    tip_radius: float = parameter(50e-6, 1e-12, key="tip_radius_um", unit=1e-6)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the forces that the surface makes of the contacts."""
        length = self.wavelength * 1.5 ** random.uniform(-1, 1, WAVES)
        turn = random.uniform(0, 2 * np.pi, WAVES)
        waves = 2 * np.pi / length * np.stack([np.cos(turn), np.sin(turn)])
        phase = random.uniform(0, 2 * np.pi, WAVES)

        def move(places: Floats) -> tuple[Floats, Floats]:
            height = self.rms * np.sqrt(2 / WAVES) * np.cos(places @ waves + phase).sum(axis=-1)
            return np.zeros_like(places), height

        for field in stream:
            yield altered(field, rig=field.rig.with_move(move, self.tip_radius))

    def strays(self, field: Field, slopes: Slopes, frames: int) -> float:
        """Bound of the change on hills as high as there are under so many frames, for the frames of a field."""
        return raised(field, [(self.rises(frames), self.tip_radius)], slopes.rises)

    def rises(self, frames: int) -> float:
        """Bound of how far [m] it raises or lowers contacts in so many frames."""
        return self.rms * min(sigmas(frames), math.sqrt(2 * WAVES))
