"""Strain nonlinearity: rubber stiffens when pressed and softens when pulled."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class StrainNonlinearity:
    """Normal readings follow neo-Hookean rubber in uniaxial load, by ``strength`` from 0 (linear) to 1.

    A linear strain e is a stress E e; the rubber's stretch l under it solves l - 1 / l^2 = 3 e, and the reading
    becomes e + strength (l - 1 - e), near zero e + strength e^2. Shear does not change: neo-Hookean rubber is linear
    in it. An estimate of the size at high strain, not a solution of the finite-strain contact. Stress is treated alike
    in units of E.

    Source: Treloar, The Physics of Rubber Elasticity; Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    strength: float = parameter(1.0, 0.0, 1.0, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with nonlinear strain."""
        for batch in stream:
            linear = batch.values[..., 2] / batch.unit
            values = batch.values.copy()
            values[..., 2] += self.strength * batch.unit * (stretch(linear) - 1 - linear)
            yield replace(batch, values=values)


def stretch(linear: Floats) -> Floats:
    """Solve l - 1 / l^2 = 3 e for l > 0. Newton from below: the left side is concave, so it never overshoots."""
    stretched = np.where(linear < 0, 1 / np.sqrt(1 - 3 * np.minimum(linear, 0)), 1.0)
    for _ in range(40):
        step = (3 * linear - stretched + stretched**-2) / (1 + 2 * stretched**-3)
        stretched += step
        if (np.abs(step) <= 1e-15 * stretched).all():
            break
    return stretched
