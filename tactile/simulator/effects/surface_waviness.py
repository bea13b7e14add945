"""Surface waviness: hills and valleys of the cover under a held contact."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field

WAVES = 32


@effect("field", random=True)
class SurfaceWaviness:
    """A random surface of standard deviation ``rms`` [m] with hills ``wavelength`` [m] apart.

    The height h(x, y) is a sum of 32 plane waves of random directions and phases, wavelengths within a factor 1.5 of
    ``wavelength``; mean 0 and standard deviation ``rms`` over the plane, the same surface for the whole scene. A held
    contact presses by h deeper. Its own law of force and indentation delta on the cover gives the force: on the
    half-space (1 + h / delta)^1.5 as much for a sphere, 1 + h / delta for a flat end, Sneddon's law for a needle;
    ``lines.line_indentation`` for a cylinder and for an edge of this ``tip_radius`` [m]; ``layer_contact`` on a layer.
    A point load has the law of a sphere of ``tip_radius``. Slopes do not turn the force.

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    rms: float = parameter(0.5e-6, key="rms_um", unit=1e-6, none=0.0)
    wavelength: float = parameter(1e-3, 1e-9, key="wavelength_mm", unit=1e-3)
    tip_radius: float = parameter(50e-6, 1e-12, key="tip_radius_um", unit=1e-6)

    @property
    def highest(self) -> tuple[float, float]:
        """Displacement across, and six standard deviations of the height [m]."""
        return 0.0, 6 * self.rms

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the forces that the surface makes."""
        length = self.wavelength * 1.5 ** random.uniform(-1, 1, WAVES)
        turn = random.uniform(0, 2 * np.pi, WAVES)
        waves = 2 * np.pi / length * np.stack([np.cos(turn), np.sin(turn)])
        phase = random.uniform(0, 2 * np.pi, WAVES)

        def move(places: Floats) -> tuple[Floats, Floats]:
            height = self.rms * np.sqrt(2 / WAVES) * np.cos(places @ waves + phase).sum(axis=-1)
            return np.zeros_like(places), height

        for field in stream:
            yield replace(field, rig=field.rig.with_move(move, self.tip_radius))
