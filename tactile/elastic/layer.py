"""Elastic layer bonded to a rigid base: transfer functions of plane waves from tractions to strain or stress."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.elastic.medium import Medium


@dataclass(frozen=True)
class Transfer:
    """Reading per surface traction of one wave exp(i k . x), k along s, t across it; all real, per Pa.

    z-z reading = ``normal`` p + i ``normal_shear`` q_s; s-z reading = i ``shear_normal`` p + ``shear`` q_s;
    t-z reading = ``across`` q_t. The traction (q_s, q_t, p) acts on the body, p presses.
    """

    normal: Floats
    normal_shear: Floats
    shear_normal: Floats
    shear: Floats
    across: Floats


def transfer(wavenumber: ArrayLike, depth: float, thickness: float, medium: Medium) -> Transfer:
    """Return the transfer functions at ``depth`` of a layer ``thickness`` [m] thick, infinite for the half-space.

    In the plane of k and z the displacement is (i U, W) with, for e = exp(-k z), y = h - z, kappa = 3 - 4 nu,

        a1 (e, -e) + a2 (k z e, -(k z + kappa) e) + a3 (f, f) + a4 (k y f, (k y + kappa) f),   f = exp(-k y),

    a3, a4 from U = W = 0 at the base and a1, a2 from the traction on top. No term grows with k or divides by 1 - 2 nu,
    so that any Poisson's ratio up to 1/2 and any thickness is allowed. Across k the shear is cosh(k y) / cosh(k h).

    Arguments: ``wavenumber`` k >= 0 [1/m], any shape.

    Raises:
        InputError: a depth outside 0 .. thickness, a thickness that is not positive, a negative wavenumber.

    Source: Papkovich-Neuber potentials; Johnson, Contact Mechanics, sect. 5.8, for the layer.
    """
    k = np.asarray(wavenumber, dtype=np.float64)
    if not (thickness > 0 and 0 <= depth <= thickness and np.isfinite(depth)):
        raise InputError(f"depth {depth} m in a layer of {thickness} m, a depth from 0 to the thickness wanted")
    if not (k >= 0).all():
        raise InputError("wavenumbers from 0 up wanted")
    nu, kappa = medium.nu, 3 - 4 * medium.nu
    # a layer so thick that no wave reaches its base is the half-space; kh stays a number, exp(-kh) is 0
    kh = np.minimum(k * thickness, 1e4) if np.isfinite(thickness) else np.full_like(k, 1e4)
    base = np.exp(-kh)
    # base amplitudes over exp(-kh), from a unit a1 and a unit a2
    back = np.array([[-np.ones_like(k), 2 / kappa * np.ones_like(k)], [-kh, (2 * kh + kappa) / kappa]])
    top = np.empty((2, 2, *k.shape))  # rows: sigma_zz / 2Gk and sigma_sz / iGk at the top; columns a1, a2
    for j, (push, drag) in enumerate(((1.0, -2.0), (2 - 2 * nu, -2 + 4 * nu))):
        top[0, j] = push + base**2 * (back[j, 0] + back[j, 1] * (kh + 2 - 2 * nu))
        top[1, j] = drag + base**2 * (2 * back[j, 0] + back[j, 1] * (2 - 4 * nu + 2 * kh))
    determinant = top[0, 0] * top[1, 1] - top[0, 1] * top[1, 0]
    kz = np.minimum(k * depth, 1e4)
    ky = kh - kz if np.isfinite(thickness) else np.full_like(k, 1e4)
    down, up = np.exp(-kz), np.exp(-np.maximum(ky, 0)) * base
    double = 1.0 if medium.quantity == "stress" else 1 / (2 * medium.shear_modulus)

    def reading(a1: Floats, a2: Floats) -> tuple[Floats, Floats]:
        """(z-z, s-z / i) readings from the amplitudes times 2 G k."""
        a3, a4 = back[0, 0] * a1 + back[1, 0] * a2, back[0, 1] * a1 + back[1, 1] * a2
        # W' where strain is read; sigma_zz / 2G = W' + nu / (1 - 2 nu) div, with div ~ 1 - 2 nu, where stress is
        own = 2 - 2 * nu if medium.quantity == "stress" else kappa - 1
        zz = down * (a1 + a2 * (kz + own)) + up * (a3 + a4 * (ky + own))
        sz = down * (-a1 + a2 * (-1 + 2 * nu - kz)) + up * (a3 + a4 * (1 - 2 * nu + ky))
        return double * zz, double * sz

    # p = 1: sigma_zz = -1 at the top; q_s = 1: sigma_sz = -1, that is sigma_sz / i = i
    pressed = reading(-top[1, 1] / determinant, top[1, 0] / determinant)
    dragged = reading(-2 * top[0, 1] / determinant, 2 * top[0, 0] / determinant)
    rim = np.exp(-kz) * (1 + np.exp(-2 * np.maximum(ky, 0))) / (1 + base**2)
    return Transfer(pressed[0], dragged[0], pressed[1], -dragged[1], -double * rim)
