"""Laws of rubber: compressible neo-Hookean solids in three formulations of the volume; Hooke's law at small strain.

All have the first Piola-Kirchhoff stress P and its derivative A in one form, of the scalars s and m,

    P = G F + s F^-T,    A_iJkL = G d_ik d_JL - s F^-1_Li F^-1_Jk + m F^-1_Ji F^-1_Lk

Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, ch. 6.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from cnnsim.support import Floats
from tactile.elastic.medium import Medium


class Law(Protocol):
    """A material; ``mixed``: the pressure is an unknown."""

    mixed: ClassVar[bool]

    @property
    def medium(self) -> Medium: ...  # noqa: D102 - its constants
    def terms(self, volume: Floats, pressure: Floats) -> tuple[Floats, Floats]: ...  # noqa: D102 - s and m


def lame(medium: Medium) -> float:
    """Lame's lambda = 2 G nu / (1 - 2 nu) [Pa], infinite at nu = 1/2."""
    return 2 * medium.shear_modulus * medium.nu / (1 - 2 * medium.nu) if medium.nu < 0.5 else np.inf


@dataclass(frozen=True)
class Mixed:
    """Displacement and pressure: W = G/2 (I1 - 3 - 2 ln J) + p (J - 1) - p^2 / (2 lambda), good up to nu = 1/2."""

    medium: Medium
    mixed: ClassVar[bool] = True

    def terms(self, volume: Floats, pressure: Floats) -> tuple[Floats, Floats]:
        """s = p J - G and m = p J."""
        return pressure * volume - self.medium.shear_modulus, pressure * volume

    @property
    def compliance(self) -> float:
        """1 / lambda [1/Pa]; at nu = 0, where lambda is 0, 1e-12 G stands for it."""
        g = self.medium.shear_modulus
        return 1 / max(lame(self.medium), 1e-12 * g)


@dataclass(frozen=True)
class Displacement:
    """Displacement alone: p = lambda (J - 1) in the same energy. Locks where lambda is large: for comparison only."""

    medium: Medium
    mixed: ClassVar[bool] = False

    def terms(self, volume: Floats, pressure: Floats) -> tuple[Floats, Floats]:
        """s = lambda J (J - 1) - G and m = lambda J (2 J - 1)."""
        lam = lame(self.medium)
        return lam * volume * (volume - 1) - self.medium.shear_modulus, lam * volume * (2 * volume - 1)


@dataclass(frozen=True)
class PlaneStress:
    """Plane stress: F_yy = f follows from P_yy = 0, a quadratic equation,

        f^2 (G + lambda J2^2) - lambda J2 f - G = 0,    J2 the change of area in the plane

    Displacement alone, and it does not lock: in place of lambda stands 2 G lambda / (lambda + 2 G), below 2 G.
    """

    medium: Medium
    mixed: ClassVar[bool] = False

    def terms(self, volume: Floats, pressure: Floats) -> tuple[Floats, Floats]:
        """s = -G f^2 and m = -2 G f J2 df/dJ2, where ``volume`` is J2, F_yy being 1 in the gradient."""
        g, f = self.medium.shear_modulus, self.thickening(volume)
        lam = lame(self.medium)
        if np.isinf(lam):
            return -g * f**2, 2 * g * f**2  # f = 1 / J2
        slope = -(2 * volume * f**2 - f) * lam / (2 * f * (g + lam * volume**2) - lam * volume)
        return -g * f**2, -2 * g * f * volume * slope

    def thickening(self, area: Floats) -> Floats:
        """f = F_yy [1] for a change of area J2 in the plane."""
        g, lam = self.medium.shear_modulus, lame(self.medium)
        if np.isinf(lam):
            return 1 / area
        root = np.sqrt((lam * area) ** 2 + 4 * g * (g + lam * area**2))
        thick: Floats = (lam * area + root) / (2 * (g + lam * area**2))
        return thick


def stress(law: Law, gradient: Floats, pressure: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """(P, F^-1, J, s, m) for deformation gradients (..., 3, 3) and pressures (...)."""
    inverse = np.asarray(np.linalg.inv(gradient), np.float64)
    volume = np.asarray(np.linalg.det(gradient), np.float64)
    s, m = law.terms(volume, pressure)
    return law.medium.shear_modulus * gradient + s[..., None, None] * _flip(inverse), inverse, volume, s, m


def tangent(law: Law, inverse: Floats, s: Floats, m: Floats) -> Floats:
    """A (..., 9, 9), rows and columns the components (i, J) and (k, L) row by row."""
    flipped = _flip(inverse)
    # F^-1_Li F^-1_Jk = flipped_iL flipped_kJ
    out = -s[..., None, None, None, None] * np.einsum("...il,...kj->...ijkl", flipped, flipped)
    out += m[..., None, None, None, None] * np.einsum("...ij,...kl->...ijkl", flipped, flipped)
    out = out.reshape(*out.shape[:-4], 9, 9)
    out[..., range(9), range(9)] += law.medium.shear_modulus
    return out


def _flip(of: Floats) -> Floats:
    return np.swapaxes(of, -1, -2)
