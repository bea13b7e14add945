"""Taxel inverse: place and size of a point load from the three strains or stresses at one point.

Source: Vasarhelyi, Fodor, Roska, eqs (2) to (11), in forms that hold everywhere: (5) as printed cancels right
above the taxel and (8) is 0/0 on the ring rho = sqrt(2) z. Here every sum has terms of one sign.

With s = Q x + R y + F z, t = rho^2 / z^2, the signals scaled by the largest of them, a = |(u_xz, u_yz)|,
b = |u_zz| and m = 3 b + sqrt(9 b^2 + 8 a^2):

    sqrt(t_in) = 4 a / m,   sqrt(t_out) = m / (2 a)    the roots of (4), inside and outside the ring
    |s| / z = (4 pi E z^2 / 3) (t + 1)^(3/2) (3 sqrt(t) a + |t - 2| b) / (t + 4)

Divisions and square roots take most of the time: with sqrt(t) = a n / d and p = a^2 n^2 + d^2 (t + 1 = p / d^2),
q = a^2 n^2 + 4 d^2, the one reciprocal 1 / (d q) gives 1 / d and (t + 1)^(3/2) / (t + 4) = p^(3/2) / (d q).

One strain taxel cannot determine the sign of s. For s > 0 it lies on the side that (u_xz, u_yz) points to, and
u_zz < 0 means inside; for s < 0 (a pull, or strong shear) azimuth and region swap. A stress taxel can: the
sign of sigma_zz is the sign of -s, and there is a single candidate.
"""

from importlib import import_module
from importlib.resources import files

import numpy as np

from cnnsim.operations.cellwise import Cellwise, Planes
from cnnsim.support import Array
from tactile.inverse.validity import FAR, Validity


def invert_strain(
    u_xz: Array, u_yz: Array, u_zz: Array, depth: float, modulus: float, floor: float, pressing: float
) -> Planes:
    """Return the planes (dx, dy, force, validity) of the load that each strain taxel measures.

    ``dx``, ``dy`` [m]: the load's place minus the taxel's; ``force`` [N]: s / z = (Q x + R y + F z) / z, which is
    F for a normal load; ``validity``: ``Validity`` as a number. All in the dtype of the inputs, 0 where there is
    no answer, so that programs receive no NaN.

    Arguments: strains of any one shape; ``depth`` z [m]; ``modulus`` E [Pa]; ``floor``: the largest |strain| that
    counts as no load (0: only exact zeros); ``pressing``: 1 where s > 0 is known (a pressing load without shear,
    the paper's case), -1 where s < 0 is known, 0 where neither is. With 0 the candidate s > 0 comes back as
    AMBIGUOUS, and a call with -1 gives the other one; only a load straight above the taxel is unique then, since
    the other candidate lies at infinity.

    Source: Vasarhelyi, Fodor, Roska, eqs (2) to (9).
    """
    x, y, z, largest, finite = _scaled(u_xz, u_yz, u_zz)
    number = x.dtype.type
    with np.errstate(all="ignore"):
        a2 = x * x + y * y
        b = np.abs(z)
        m = 3 * b + np.sqrt(9 * b * b + 8 * a2)
        straight = a2 <= number(FAR * FAR) * b * b
        # sign of s: as given, except that a load straight above must be inside
        sign = np.where((pressing == 0) & straight & (z > 0), number(-1), number(-1 if pressing < 0 else 1))
        inside = sign * z < 0
        n = np.where(inside, number(4), m)
        d = np.where(inside, m, 2 * np.where(straight, number(1), a2))
        n2, d2 = a2 * n * n, d * d
        p, q = n2 + d2, n2 + 4 * d2
        over = 1 / (d * q)
        over_d = q * over
        reach = n * over_d  # sqrt(t) / a
        t = a2 * reach * reach
        force = (3 * a2 * reach + np.abs(t - 2) * b) * (p * np.sqrt(p) * over)
        force = sign * force * (number(4 * np.pi / 3 * modulus * depth * depth) * largest)
        length = sign * number(depth) * reach
        possible = finite & (inside | ~straight) & np.isfinite(force)
    region = np.where(inside, number(Validity.INSIDE), number(Validity.OUTSIDE))
    if pressing == 0:
        region = np.where(straight, region, number(Validity.AMBIGUOUS))
    return _answer(length * x, length * y, force, region, possible, ~finite | (largest > number(floor)))


def invert_stress(s_xz: Array, s_yz: Array, s_zz: Array, depth: float, floor: float) -> Planes:
    """Return the planes (dx, dy, force, validity) of the load that each stress taxel measures.

    With the taxel's (x, y) = z (sigma_xz, sigma_yz) / sigma_zz seen from the load,

        s / z = -(2 pi z^2 / 3) (1 + rho^2 / z^2)^(5/2) sigma_zz

    Planes and arguments: as ``invert_strain``, stresses and ``floor`` in [Pa]. Never ambiguous; where sigma_zz is
    negligible against the shear stress the load is out of reach: INVALID.

    Source: Vasarhelyi, Fodor, Roska, eqs (10), (11).
    """
    x, y, z, largest, finite = _scaled(s_xz, s_yz, s_zz)
    number = x.dtype.type
    with np.errstate(all="ignore"):
        reachable = np.abs(z) > number(FAR)
        over = 1 / np.where(reachable, z, number(1))
        across, along = x * over, y * over
        t = across * across + along * along
        force = (t + 1) * (t + 1) * np.sqrt(t + 1) * -z
        force = force * (number(2 * np.pi / 3 * depth * depth) * largest)
        possible = finite & reachable & np.isfinite(force)
    region = np.where(t < 2, number(Validity.INSIDE), number(Validity.OUTSIDE))
    length = number(-depth)
    return _answer(length * across, length * along, force, region, possible, ~finite | (largest > number(floor)))


def _scaled(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the signals over the largest of the three, that largest, and where all three are finite.

    Squares of small strains leave the range of float32; ratios to the largest do not. TaxelSignals below the smallest
    normal number of the dtype (1e-38 in float32) count as zero.
    """
    x, y, z = (np.asarray(plane) for plane in (x, y, z))
    if x.dtype not in (np.float32, np.float64):
        x, y, z = (plane.astype(np.float64) for plane in (x, y, z))
    finite = np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
    zero, one = x.dtype.type(0), x.dtype.type(1)
    x, y, z = (np.where(finite, plane, zero) for plane in (x, y, z))
    largest = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z))
    some = largest >= np.finfo(x.dtype).tiny
    over = one / np.where(some, largest, one)
    # without a load a fixed direction avoids 0/0 below
    return x * over, y * over, np.where(some, z * over, -one), np.where(some, largest, zero), finite


def _answer(
    dx: Array, dy: Array, force: Array, region: Array, possible: Array, loaded: Array
) -> tuple[Array, Array, Array, Array]:
    """Mark the taxels without an answer and set their planes to 0."""
    zero = dx.dtype.type(0)
    answered = possible & loaded
    validity = np.where(possible, region, dx.dtype.type(Validity.INVALID))
    return (
        np.where(answered, dx, zero),
        np.where(answered, dy, zero),
        np.where(answered, force, zero),
        np.where(loaded, validity, zero),
    )


def _opencl(name: str, letter: str) -> str:
    parts = [(files("tactile.inverse") / f"{part}.cl").read_text(encoding="utf-8") for part in ("scaled", name)]
    inputs = ", ".join(f"in_{axis} = {letter}_{axis}" for axis in ("xz", "yz", "zz"))
    return f"const real {inputs};\n" + "".join(parts)


STRAIN_INVERSE = Cellwise(
    "strain-inverse",
    "the point load over an elastic half-space that a strain taxel measures",
    ("u_xz", "u_yz", "u_zz"),
    ("dx", "dy", "force", "validity"),
    ("depth", "modulus", "floor", "pressing"),
    invert_strain,
    lambda: import_module("tactile.inverse.taxel_numba").strain_inverse,
    _opencl("strain", "u"),
)
STRESS_INVERSE = Cellwise(
    "stress-inverse",
    "the point load over an elastic half-space that a stress taxel measures",
    ("s_xz", "s_yz", "s_zz"),
    ("dx", "dy", "force", "validity"),
    ("depth", "floor"),
    invert_stress,
    lambda: import_module("tactile.inverse.taxel_numba").stress_inverse,
    _opencl("stress", "s"),
)
