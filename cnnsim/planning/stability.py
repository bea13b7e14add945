"""Stability: the longest step of a scheme with which no decaying mode of a linear template grows."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cnnsim.network import Boundary, Tap, Template
from cnnsim.network.boundary import correlate
from cnnsim.network.weights import taps_of
from cnnsim.planning.duration import Duration
from cnnsim.planning.scheme import EULER, RK4, Scheme
from cnnsim.support import Floats

Modes = NDArray[np.complex128]
"""Eigenvalues of the linear region, A - I, per time constant."""

_SIDES = (1, 2, 3, 5, 10, 16)
"""Sides of the grids whose eigenvalues are taken: any group of cells may be linear while the others are saturated."""
_MOST_CELLS = 160
_NEUTRAL = 1e-6
"""A mode that decays by less than this part of its modulus neither decays nor grows."""

RUSHED = 0.4
"""Growth over frequency from which a mode that begins between saturated cells saturates before it has turned far.

0.5 in waves of connected components, of which only the places at which they begin and end are not saturated.
"""
ASTRAY = 0.05
"""Part of a mode by which steps may make it too large."""


def modes_of(template: Template, boundary: Boundary) -> Modes:
    """Return the modes of the linear region, the eigenvalues of A - I.

    For a symmetric A or a torus, the symbol sum A(k, l) exp(i (k p + l q)) - 1 has them all. For any other A they are
    computed on grids of several sizes (its symbol would forbid steps that are stable).
    """
    if template.symmetric or boundary.kind == "periodic":
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
    """Return those of the modes that decay, one of each complex pair, and that of a saturated cell: rate 1."""
    modes = np.append(modes.astype(complex), -1)
    return modes[(modes.real < -_NEUTRAL * np.abs(modes)) & (modes.imag >= 0)]


@lru_cache(maxsize=64)
def _on_grids(entries: bytes, side: int, boundary: Boundary) -> Modes:
    A: Floats = np.frombuffer(entries).reshape(side, side)
    shapes = [(m, n) for m in _SIDES for n in _SIDES if m * n <= _MOST_CELLS]
    return np.concatenate([np.linalg.eigvals(coupling(A, shape, boundary)) for shape in shapes]) - 1


def coupling(A: Floats, shape: tuple[int, int], boundary: Boundary) -> Floats:
    """Return the matrix (cells, cells) of A on a grid, whose virtual cells follow the boundary, constants left out."""
    cells = shape[0] * shape[1]
    each = np.eye(cells).reshape(-1, *shape)
    return correlate(each, taps_of(A), boundary, 0.0, np.zeros_like(each)).reshape(cells, cells).T


def step_limit(template: Template, boundary: Boundary, duration: Duration, scheme: Scheme) -> float:
    """Return the step that cannot be reached: |R(h mode)| > 1 beyond it. Infinite if the scheme damps any step.

    Euler: h < 2 |Re mode| / |mode|^2, so 2 for a cell without neighbours and 1/4 for the five-point Laplacian.
    """
    return _limit(template, boundary, duration, scheme)


@lru_cache(maxsize=128)
def _limit(template: Template, boundary: Boundary, duration: Duration, scheme: Scheme) -> float:
    return limit_of(decaying(modes_of(template, boundary)), duration, scheme)


def limit_of(modes: Modes, duration: Duration, scheme: Scheme) -> float:
    """Return the step from which on one of the decaying modes grows; one that turns, e-fold within the duration.

    Without that allowance a mode that hardly decays at all would forbid Euler for the shortest of runs.
    """
    allowed = 0.0 if duration == "settled" or not duration else 1 / duration
    real, turning = modes.real[modes.imag == 0], np.unique(np.round(modes[modes.imag > 0] - allowed, 6))
    gain = min(scheme.real_limit / -real.min(), scheme.gain_limit(turning[turning != 0]))
    if not scheme.exponential:
        return float(gain)
    return float(-np.log1p(-gain)) if gain < 1 else float("inf")


def fastest_turning(modes: Modes, duration: Duration, step: float, *, grey: bool = False) -> float:
    """Return the |omega| of the fastest mode that Euler's steps do not follow, 0 if there is none.

    They make a mode that turns grow by h omega^2 / 2 a time constant too fast, until the run ends or the mode is e
    times smaller or larger. What grows at more than `RUSHED` of its frequency is saturated before that tells, unless
    the run begins from a ``grey`` state: whole groups of cells are linear then, and which way they saturate hangs on
    how far they turn meanwhile. Of what grows at ``rate`` Euler's steps are late by h omega rate a time constant.
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
    """Return the |omega| of the fastest mode of a linear template that Euler's steps do not follow.

    On a grid with edges waves that grow as they travel are no modes, but are there until they come to an edge: from a
    grey state they are followed as well.
    """
    modes = modes_of(template, boundary)
    if grey and not template.symmetric:
        waves = _waves(template.feedback_taps, symmetric=False)
        modes = np.append(modes, waves[waves.real > 0])
    return fastest_turning(modes, duration, step, grey=grey)


def late_growth(template: Template, step: float) -> tuple[float, float]:
    """Return the rate g at which the fastest pattern grows [1 / time constant], and the part of it Euler's steps lose.

    In a step they make of exp(h g) only 1 + h g, so they grow at log(1 + h g) / h, which favours the slower of two
    patterns that compete; which of them wins hangs on that where the run begins from a grey state.
    """
    rate = max(0.0, float(_waves(template.feedback_taps, symmetric=template.symmetric).real.max()))
    return rate, 1 - float(np.log1p(step * rate)) / (step * rate) if rate else 0.0


def turning_from(turning: Callable[..., float], grey: Callable[[], bool]) -> float:
    """Return the |omega| that ``turning`` (with ``grey``, as `fastest_turning`) gives for the state of a run.

    The state is looked at only where that makes a difference: it may be large.
    """
    either, most = turning(grey=False), turning(grey=True)
    return most if most > either and grey() else either


def usual_scheme(limit: Callable[[Scheme], float], step: float, turning: float) -> Scheme:
    """Return Euler, or RK4 where modes turn so fast that it gets on better: a step of it costs four of Euler's.

    Arguments: ``limit`` gives the longest step of a scheme; ``step`` is what accuracy allows [time constants];
    ``turning`` as in `fastest_turning`.
    """
    return RK4 if turning or (limit(EULER) < 2 * step and limit(RK4) > 4 * limit(EULER)) else EULER
