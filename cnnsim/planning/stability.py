"""How long an explicit step may be before a template's decaying modes grow in the numbers."""

import numpy as np

from cnnsim.network.boundary import Boundary, pad
from cnnsim.network.template import Template
from cnnsim.planning.scheme import Scheme

_SMALL = 10  # side of the grid on which eigenvalues are computed where no symbol gives them


def fastest_decay(template: Template, boundary: Boundary) -> float:
    """Return the largest decay rate of the network, 1 - min(0, min Re eig A), per time constant.

    Saturated cells decay at rate 1. In the linear region the rates are those of A - I: for a symmetric A or a torus,
    the symbol sum A(k, l) exp(i (k p + l q)) bounds them on every grid; for any other A the eigenvalues of a
    10 x 10 grid are taken (its symbol would forbid steps that are stable).
    """
    if template.symmetric or boundary.kind == "periodic":
        k, l, weight = (np.array([tap[i] for tap in template.feedback_taps]) for i in range(3))
        frequency = np.linspace(-np.pi, np.pi, 129)
        p, q = np.meshgrid(frequency, frequency[64:], indexing="ij")
        slowest = (weight * np.cos(p[..., None] * k + q[..., None] * l)).sum(axis=-1).min()
    else:
        cells = np.eye(_SMALL * _SMALL).reshape(-1, _SMALL, _SMALL)
        r = template.A.shape[0] // 2
        around = pad(cells, r, boundary, 0.0)
        rows = sum(
            tap.weight * around[:, r + tap.k : r + tap.k + _SMALL, r + tap.l : r + tap.l + _SMALL]
            for tap in template.feedback_taps
        )
        slowest = np.linalg.eigvals(np.reshape(rows, (_SMALL * _SMALL, -1)).T).real.min()
    return 1.0 - min(0.0, float(slowest))


def step_limit(template: Template, boundary: Boundary, scheme: Scheme) -> float:
    """Return the step that cannot be reached: |R(-h rate)| > 1 beyond it. Infinite if the scheme damps any step.

    Euler: h < 2 / (1 - min Re eig A), so 2 for a cell without neighbours and 1/4 for the five-point Laplacian.
    """
    gain = scheme.real_limit / fastest_decay(template, boundary)
    if not scheme.exponential:
        return gain
    return float(-np.log1p(-gain)) if gain < 1 else float("inf")
