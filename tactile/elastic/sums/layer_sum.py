"""Share of a bonded layer, layer minus half-space, in the field of point loads, compiled.

With N(k) the difference of the transfer functions, a load P = (Q, R, F) at distance rho = |(x, y)| adds

    zz: F I0[normal] - (Q x + R y) / rho I1[normal_shear]
    xz: -F x / rho I1[shear_normal] + Q I0[(shear + across) / 2]
        - ((2 x^2 / rho^2 - 1) Q + 2 x y / rho^2 R) I2[(shear - across) / 2]

and yz alike, where Im[N] = integral of k N(k) Jm(k rho) dk / (2 pi). The difference falls off like exp(-k (2 h - z)):
the integrals are short and smooth at any depth. Far from a load the sum of both is the layer's small field.
"""

import math

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.compiled_loops import kept_njit
from tactile.core.loads import F, Q, R, X, Y
from tactile.elastic.halfspace import point_scale
from tactile.elastic.layer_loads import REACH, layer_table
from tactile.elastic.medium import Medium


def add_layer_term(out: Floats, positions: Floats, depth: float, loads: Floats, medium: Medium) -> None:
    """Add the layer's share to ``out`` (frames, taxels, 3).

    Arguments: ``positions`` (taxels, 2) [m]; ``depth`` [m], at most the thickness; ``loads`` (frames, n, 5) [m, N].
    """
    thickness = medium.thickness
    spline = layer_table(depth / thickness, medium.nu, medium.quantity)
    table = np.ascontiguousarray(np.moveaxis(spline.c, 0, 1))  # (intervals, powers from the third down, functions)
    x, y = (np.ascontiguousarray(positions[:, axis]) for axis in (0, 1))
    unit = (1.0 if medium.quantity == "stress" else 1 / medium.modulus) / thickness**2
    _add(x, y, np.ascontiguousarray(loads), table, REACH * thickness, unit, 1 / depth, *point_scale(depth, medium), out)


@kept_njit(error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _add(x_of, y_of, loads, table, reach, unit, over_depth, scale, trace, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    intervals, shares = table.shape[0], np.empty(5)
    for n in range(loads.shape[0]):
        for m in range(loads.shape[1]):
            x0, y0, q, r, f = loads[n, m, X], loads[n, m, Y], loads[n, m, Q], loads[n, m, R], loads[n, m, F]
            if q == 0 and r == 0 and f == 0:
                continue
            for i in range(x_of.size):
                x, y = x_of[i] - x0, y_of[i] - y0
                rho = math.sqrt(x * x + y * y)
                if rho >= reach:  # the layer's field is 0: remove the half-space's
                    x, y = x * over_depth, y * over_depth
                    near = 1 / (1 + x * x + y * y)
                    weight = scale * (q * x + r * y + f) * near * math.sqrt(near)
                    out[n, i, 0] += 3 * weight * near * x
                    out[n, i, 1] += 3 * weight * near * y
                    out[n, i, 2] -= weight * (trace - 3 * near)
                    continue
                at = math.sqrt(rho / reach) * intervals
                k = min(int(at), intervals - 1)
                t = (at - k) / intervals
                for c in range(5):
                    shares[c] = unit * (
                        ((table[k, 0, c] * t + table[k, 1, c]) * t + table[k, 2, c]) * t + table[k, 3, c]
                    )
                normal, normal_shear, shear_normal, even, odd = shares[0], shares[1], shares[2], shares[3], shares[4]
                c_, s = 1.0, 0.0
                if rho > 0:
                    c_, s = x / rho, y / rho
                along = q * c_ + r * s
                out[n, i, 0] += q * even - f * c_ * shear_normal - (2 * c_ * along - q) * odd
                out[n, i, 1] += r * even - f * s * shear_normal - (2 * s * along - r) * odd
                out[n, i, 2] += f * normal - along * normal_shear
