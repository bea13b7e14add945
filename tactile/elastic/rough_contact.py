"""Contact of a rigid body of any shape with a half-space or layer: pressures on a grid, by conjugate gradients."""

from functools import lru_cache

import numpy as np
from scipy import fft
from scipy.interpolate import CubicSpline
from scipy.special import j0

from cnnsim.support import Floats, InputError
from tactile.elastic.gauss import gauss, panels
from tactile.elastic.layer_surface import excess
from tactile.elastic.medium import Medium

STEPS = 1000
"""Most steps of the solver; a contact of 128 x 128 cells takes some dozens."""
TOLERANCE = 1e-6
"""Largest residual gap, relative to the indentation."""
ACROSS = 3
"""Gauss points across a cell, over which the base's reduction is averaged: the displacement of a thin, incompressible
cover is the difference of two large ones."""
REACH = 40.0
"""Distance in thicknesses beyond which the layer's surface does not move, to 1e-6 of its largest displacement."""


class RoughContact:
    """Pressures under a body whose underside has heights (rows, cols) [m] over a plane, cells of one pitch [m].

    ``lowest`` height [m], which may lie between the cells' middles; None for the lowest of them.

    Minimises p G p / 2 - p (indentation - height) over pressures p >= 0 (no pull, no friction), G the displacement of a
    cell under pressure on another: Love's square on the half-space, less the base's reduction,
    pitch^2 / (pi E* h) integral of (1 - T(k)) J0(k r / h) dk.

    Raises:
        InputError: no two-dimensional heights, heights that are not finite, a pitch that is not positive.

    Source: Polonsky and Keer (1999); Vollebregt (2014) for a given indentation; Johnson, sect. 3.3; ``layer_contact``.
    """

    def __init__(self, heights: Floats, pitch: float, medium: Medium, lowest: float | None = None) -> None:
        if heights.ndim != 2 or not heights.size or not np.isfinite(heights).all() or not pitch > 0:
            raise InputError(f"heights of shape {heights.shape} {pitch} m apart; finite (rows, cols), a pitch wanted")
        self.gap, self.pitch, self.medium = heights - (heights.min() if lowest is None else lowest), pitch, medium
        rows, cols = (np.arange(n, dtype=np.float64) * pitch for n in heights.shape)
        self._moved = _displacement(cols[None, :], rows[:, None], pitch, medium)
        self._transform()

    def _transform(self) -> None:
        self._size = [fft.next_fast_len(2 * n - 1, real=True) for n in self.gap.shape]
        # distances beyond the grid, which padding adds, are never used
        rows, cols = (
            np.minimum(np.minimum(np.arange(n), n - np.arange(n)), m - 1)
            for n, m in zip(self._size, self.gap.shape, strict=True)
        )
        self._transfer = fft.rfft2(self._moved[rows[:, None], cols])

    def part(self, box: tuple[slice, slice]) -> "RoughContact":
        """Return the contact on these rows and columns alone."""
        made: RoughContact = object.__new__(RoughContact)
        made.gap, made.pitch, made.medium, made._moved = self.gap[box], self.pitch, self.medium, self._moved
        made._transform()
        return made

    def sunk(self, pressure: Floats) -> Floats:
        """Return the displacement (rows, cols) [m] of the surface under pressures [Pa]."""
        rows, cols = self.gap.shape
        waves = fft.rfft2(pressure, s=self._size)
        out: Floats = fft.irfft2(waves * self._transfer, s=self._size)[:rows, :cols]
        return out

    def pressed(self, indentation: float, start: Floats | None = None) -> Floats:
        """Return the pressures (rows, cols) [Pa] at an indentation [m] of the lowest point; ``start``: a first guess.

        Raises:
            InputError: an indentation as deep as the layer is thick; no answer after a thousand steps.
        """
        if indentation >= self.medium.thickness:
            raise InputError(
                f"a body sinks {indentation * 1e3:.4g} mm into a cover of {self.medium.thickness * 1e3:g} mm; less than"
                " its thickness wanted"
            )
        wanted = indentation - self.gap
        pressure = np.zeros_like(wanted) if start is None else np.where(wanted > 0, start, 0.0)
        if indentation <= 0:
            return np.zeros_like(wanted)
        direction, last, touching = np.zeros_like(wanted), 1.0, pressure > 0
        left, summed = wanted - self.sunk(pressure), True  # above 0 where the body overlaps the surface
        for _ in range(STEPS):
            now = (pressure > 0) | (left > 0)
            residual = np.where(now, left, 0.0)
            if np.abs(residual).max() <= TOLERANCE * indentation:
                if summed:
                    return pressure
                left, summed = wanted - self.sunk(pressure), True
                continue
            size = float((residual * residual).sum())
            fresh = bool((now != touching).any())
            direction = residual if fresh else residual + size / last * direction
            last, touching = size, now
            under = self.sunk(direction)
            step = float((residual * direction).sum()) / float((direction * under)[now].sum())
            pressure = pressure + step * direction
            summed = bool((pressure < 0).any())
            if summed:
                pressure = np.maximum(pressure, 0.0)
                left = wanted - self.sunk(pressure)
            else:  # linear: no new sum
                left = left - step * under
        raise InputError(
            f"no pressures found for an indentation of {indentation * 1e3:.4g} mm in {STEPS} steps; less wanted"
        )


def _displacement(x: Floats, y: Floats, pitch: float, medium: Medium) -> Floats:
    """Return the displacement [m / Pa] of a cell at (x, y) under 1 Pa on the one at (0, 0)."""
    out = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for sign_x in (1, -1):
        for sign_y in (1, -1):
            a, b = x + sign_x * pitch / 2 + 0 * y, y + sign_y * pitch / 2 + 0 * x
            # a corner never lies at a or b of 0: cells are half a pitch wide
            out += sign_x * sign_y * (a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b)))
    out /= np.pi * medium.contact_modulus
    if np.isfinite(medium.thickness):
        h = medium.thickness
        taken, (nodes, weights) = np.zeros_like(out), gauss(ACROSS)
        for a, along in zip((nodes * pitch / 2).tolist(), weights.tolist(), strict=True):
            for b, across in zip((nodes * pitch / 2).tolist(), weights.tolist(), strict=True):
                rho = np.minimum(np.hypot(x + a, y + b) / h, REACH)
                taken += along * across / 4 * base_reduction(medium.nu)(rho)
        far = np.hypot(x, y) >= REACH * h
        out -= np.where(far, out, taken * pitch**2 / (np.pi * medium.contact_modulus * h))
    return out


@lru_cache(maxsize=16)
def base_reduction(nu: float) -> CubicSpline:
    """Return the integral of (1 - T(k)) J0(k rho) dk over the distance rho in thicknesses, up to ``REACH``."""
    k, weights = panels(20.0, 80)
    rho = np.linspace(0, REACH, 1201)
    return CubicSpline(rho, j0(np.outer(rho, k)) @ (excess(k, nu) * weights))
