"""Stability: the longest step of a scheme with which no decaying mode of a linear template grows."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cnnsim.network import Boundary, Tap, Template
from cnnsim.network.boundary import correlate
from cnnsim.network.weights import taps_of
from cnnsim.planning.scheme import EULER, RK4, Scheme
from cnnsim.planning.step import Duration
from cnnsim.support import Floats

Modes = NDArray[np.complex128]
"""Eigenvalues of the linear region, A - I, per time constant."""

_SIDES = (1, 2, 3, 5, 10, 16)
"""Sides of the grids whose eigenvalues are computed: any group of cells may be linear while others are saturated."""
_MOST_CELLS = 160
_NEUTRAL = 1e-6
"""A mode whose decay is a smaller part of its modulus counts as neutral."""

RUSHED = 0.4
"""Ratio of growth to frequency from which a mode between saturated cells saturates before it has turned far.

It is 0.5 in the waves of connected components.
"""
ASTRAY = 0.05
"""Relative error of a mode's size that steps may make."""


def modes_of(template: Template, boundary: Boundary) -> Modes:
    """Return the modes of the linear region, the eigenvalues of A - I.

    For a torus, or a symmetric A without mirrored cells, the symbol sum A(k, l) exp(i (k p + l q)) - 1 has them all.
    For any other A they are computed on grids of several sizes (its symbol would forbid steps that are stable).
    """
    if boundary.kind == "periodic" or (template.symmetric and boundary.kind != "reflecting"):
        return _waves(template.feedback_taps, symmetric=template.symmetric)
    return _on_grids(template.A.tobytes(), template.A.shape[0], boundary)


@lru_cache(maxsize=64)
def _waves(taps: tuple[Tap, ...], *, symmetric: bool) -> Modes:
    k, l, weight = (np.array([tap[i] for tap in taps]) for i in range(3))
    frequency = np.linspace(-np.pi, np.pi, 129)
    p, q = np.meshgrid(frequency, frequency[64:], indexing="ij")
    phase = p[..., None] * k + q[..., None] * l
    found: Modes = (weight * (np.cos(phase) if symmetric else np.exp(1j * phase))).sum(axis=-1).ravel() - 1
    return found


def decaying(modes: Modes) -> Modes:
    """Return the modes that decay, one of each complex pair, and the mode of a saturated cell, -1."""
    modes = np.append(modes.astype(complex), -1)
    return modes[(modes.real < -_NEUTRAL * np.abs(modes)) & (modes.imag >= 0)]


@lru_cache(maxsize=64)
def _on_grids(entries: bytes, side: int, boundary: Boundary) -> Modes:
    A: Floats = np.frombuffer(entries).reshape(side, side)
    shapes = [(m, n) for m in _SIDES for n in _SIDES if m * n <= _MOST_CELLS]
    return np.concatenate([np.linalg.eigvals(coupling(A, shape, boundary)) for shape in shapes]) - 1


def coupling(A: Floats, shape: tuple[int, int], boundary: Boundary) -> Floats:
    """Return the matrix (cells, cells) of A on a grid with its boundary; constant virtual cells are omitted."""
    cells = shape[0] * shape[1]
    each = np.eye(cells).reshape(-1, *shape)
    return correlate(each, taps_of(A), boundary, 0.0, np.zeros_like(each)).reshape(cells, cells).T


def step_limit(template: Template, boundary: Boundary, duration: Duration, scheme: Scheme) -> float:
    """Return the stability limit of the step: |R(h mode)| > 1 beyond it. Infinite if the scheme damps any step.

    Euler: h < 2 |Re mode| / |mode|^2, so 2 for a cell without neighbours and 1/4 for the five-point Laplacian.
    """
    return _limit(template, boundary, duration, scheme)


@lru_cache(maxsize=128)
def _limit(template: Template, boundary: Boundary, duration: Duration, scheme: Scheme) -> float:
    return limit_of(decaying(modes_of(template, boundary)), duration, scheme)


def limit_of(modes: Modes, duration: Duration, scheme: Scheme) -> float:
    """Return the step from which one of the decaying modes grows; an oscillating one e-fold within the duration.

    Without that allowance a mode that hardly decays would forbid Euler for short runs.
    """
    allowed = 0.0 if duration == "settled" or not duration else 1 / duration
    real, turning = modes.real[modes.imag == 0], np.unique(np.round(modes[modes.imag > 0] - allowed, 6))
    gain = min(scheme.real_limit / -real.min(), scheme.gain_limit(turning[turning != 0]))
    if not scheme.exponential:
        return float(gain)
    return float(-np.log1p(-gain)) if gain < 1 else float("inf")


def fastest_turning(modes: Modes, duration: Duration, step: float, *, grey: bool = False) -> float:
    """Return the |omega| of the fastest oscillating mode that Euler steps do not resolve, 0 if there is none.

    Euler steps add h omega^2 / 2 to the growth rate of such a mode. The error accumulates until the run ends or the
    mode has changed by a factor of e. A mode whose rate is more than `RUSHED` of its frequency saturates before the
    error matters, except from a ``grey`` state: groups of cells are linear then, and the way they saturate depends on
    the phase. The phase of a mode that grows at ``rate`` lags by h omega rate a time constant.
    """
    modes = modes[modes.imag != 0]
    omega, rate = np.abs(modes.imag), np.abs(modes.real)
    grows = modes.real > 0
    turning = omega > rate * np.where(grows, 0.0 if grey else 1 / RUSHED, 1.0)
    longest = np.inf if duration == "settled" else float(duration)
    lasts = np.minimum(longest, 1 / np.maximum(rate, 1e-300))
    late = np.maximum(omega / 2, np.where(grows & grey, rate, 0.0)) * omega * step
    return float(omega[turning & (late * lasts > ASTRAY)].max(initial=0.0))


@lru_cache(maxsize=128)
def turning_of(template: Template, boundary: Boundary, duration: Duration, step: float, *, grey: bool = False) -> float:
    """Return the |omega| of the fastest mode of a linear template that Euler steps do not resolve.

    With a ``grey`` state, travelling waves that grow count as well. On a grid with edges they are not modes, but they
    exist until they reach an edge.
    """
    modes = modes_of(template, boundary)
    if grey and not template.symmetric:
        waves = _waves(template.feedback_taps, symmetric=False)
        modes = np.append(modes, waves[waves.real > 0])
    return fastest_turning(modes, duration, step, grey=grey)


def late_growth(template: Template, step: float) -> tuple[float, float]:
    """Return the rate g of the fastest growing pattern [1 / time constant], and its relative error with Euler steps.

    An Euler step multiplies by 1 + h g instead of exp(h g), which is the rate log(1 + h g) / h. The error favours the
    slower of two competing patterns, and from a grey state it may change which pattern remains.
    """
    rate = max(0.0, float(_waves(template.feedback_taps, symmetric=template.symmetric).real.max()))
    return rate, 1 - float(np.log1p(step * rate)) / (step * rate) if rate else 0.0


def turning_from(turning: Callable[..., float], grey: Callable[[], bool]) -> float:
    """Return the |omega| that ``turning`` (see `fastest_turning`) gives for the state of a run.

    ``grey`` reads the state, so it is called only if the result depends on it.
    """
    either, most = turning(grey=False), turning(grey=True)
    return most if most > either and grey() else either


def usual_scheme(limit: Callable[[Scheme], float], step: float, turning: float) -> Scheme:
    """Return RK4 if a mode oscillates or its stable step is over four times Euler's (the ratio of costs), else Euler.

    Arguments: ``limit`` returns the longest stable step of a scheme; ``step`` is the step that accuracy allows [time
    constants]; ``turning`` as in `fastest_turning`.
    """
    return RK4 if turning or (limit(EULER) < 2 * step and limit(RK4) > 4 * limit(EULER)) else EULER
