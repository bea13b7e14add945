"""Hard templates: high gain, centres next to 1, steps at the limit of stability, starts on a ridge, long runs."""

from typing import Any

import mpmath
import numpy as np

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, run_transient
from cnnsim.backends.base import Backend
from cnnsim.support import Array
from tests.hard_cases.case import HardCase
from tests.oracles.exact_transient import exact

CROSS = np.array([[0, 1.0, 0], [1, 0, 1], [0, 1, 0]])
CENTRE = np.diag([0, 1.0, 0])
START = np.random.default_rng(77).uniform(-1, 1, (4, 5))
HEAT = 0.25 * CROSS


def _ours(template: Template, x: Array, duration: Any, **more: Any) -> Any:
    def run(backend: Backend) -> Array:
        return run_transient(template, state=x, duration=duration, backend=backend, **more).x

    return run


def _truth(A: Array, x: Array, duration: float, boundary: Any = ZERO_FLUX, z: float = 0.0) -> Any:
    return lambda: exact(A, np.full(x.shape, z), x, boundary, duration)


def _single(a: float, s: float, x0: float, t: float) -> Array:
    """The linear piece of an uncoupled cell in fifty digits: x(t) = (x0 + s/(a - 1)) exp((a - 1) t) - s/(a - 1)."""
    with mpmath.workdps(50):
        g, push, start, time = mpmath.mpf(a) - 1, mpmath.mpf(s), mpmath.mpf(x0), mpmath.mpf(t)
        return np.array([[float(start * mpmath.exp(g * time) + push * mpmath.expm1(g * time) / g)]])


def _single_naively(a: float, s: float, x0: float, t: float) -> Array:
    return np.array([[(x0 + s / (a - 1)) * np.exp((a - 1) * t) - s / (a - 1)]])


def _near_one(a: float) -> HardCase:
    x0, s, t = 0.125, 0.1, 2.0
    return HardCase(
        f"centre 1 {a - 1:+.0e}", "the closed form divides by a - 1, and its two terms of 0.1 / (a - 1) cancel",
        _ours(Template(a, z=s), np.array([[x0]]), t), lambda: _single(a, s, x0, t), 1e-15, 1e-7,
        lambda: _single_naively(a, s, x0, t), naive_fails=abs(a - 1) < 1e-6,
    )  # fmt: skip


def _euler(x: Array, A: Array, h: float, steps: int, dtype: Any = np.float64) -> Array:
    x, A = x.astype(dtype), A.astype(dtype)
    for _ in range(steps):
        y = np.pad(x.clip(-1, 1), 1, mode="edge")
        drive = sum(A[k, l] * y[k : k + x.shape[0], l : l + x.shape[1]] for k in range(3) for l in range(3))
        x = x + dtype(h) * (drive - x)
    return x


def _decayed(h: float, factor: float) -> HardCase:
    """The checkerboard decays fastest under heat: its mode is -1 - sum|A|, so Euler's limit is 2 / 2 = 1."""
    board = np.where(np.indices((4, 4)).sum(0) % 2, -0.5, 0.5)
    scale = (1 - 2 * h) ** 40
    return HardCase(
        f"step {factor} of the limit", "Euler steps hardly damp the fastest mode, a checkerboard, or amplify it",
        _ours(Template(HEAT), board, 40 * h, scheme="euler", step=h, boundary=PERIODIC),
        None if factor > 1 else lambda: board * scale, 1e-13, 1e-5, refused="cannot be stable" if factor > 1 else "",
    )  # fmt: skip


def _gain() -> HardCase:
    """A cell of gain 1e4: 1e-6 grows to 1 in ln(1e6) / 9999 time constants, then the state goes to 1e4."""
    t = 0.01
    saturates = float(np.log(1e6) / 9999)
    end = 1e4 + (1 - 1e4) * np.exp(-(t - saturates))
    return HardCase(
        "gain 1e4", "the linear piece lasts a thousandth of a time constant; a step of 0.1 jumps over it",
        _ours(Template(1e4), np.array([[1e-6, -1e-6]]), t), lambda: np.array([[end, -end]]), 1e-8, 0.05,
        lambda: _euler(np.array([[1e-6, -1e-6]]), 1e4 * CENTRE, t, 1),
    )  # fmt: skip


def _spiral() -> HardCase:
    A = np.array([[0, 0, 0], [-1.2, 2, 1.2], [0, 0, 0]])
    x, t, edge = np.array([[0.1, 0.0]]), 25.0, fixed(0)
    return HardCase(
        "oscillation", "two cells of opposite coupling oscillate without damping: phase errors accumulate",
        _ours(Template(A), x, t, boundary=edge, accuracy=1e-4), _truth(A, x, t, edge), 1e-4, 1e-3,
        lambda: _euler(np.pad(x, ((0, 0), (1, 1)))[:, 1:3], A, 0.1, 250),
    )  # fmt: skip


def _long() -> HardCase:
    """10^6 steps of heat that keeps its mean, in float64; float32 changes the mean by rounding."""
    mean = np.full(START.shape, START.mean())
    return HardCase(
        "10^6 steps", "rounding errors accumulate in the mean, a mode that does not decay",
        _ours(Template(HEAT), START, 1e5, boundary=PERIODIC, scheme="euler", step=0.1), lambda: mean, 1e-11, 1e-3,
        lambda: _euler(START, HEAT, 0.1, 5_000, np.float16).astype(float), slow=True,
    )  # fmt: skip


CASES = [
    _near_one(1 + 1e-7), _near_one(1 - 1e-7), _near_one(1.5), _gain(), _spiral(), _long(), _decayed(0.99, 0.99),
    _decayed(1.01, 1.01),
    HardCase(
        "a start on the ridge", "x = 0 without a drive is an unstable rest: any rounding error would grow",
        _ours(Template(2 * CENTRE + 0.1 * CROSS), np.zeros((3, 4)), "settled", boundary=fixed(0)),
        lambda: np.zeros((3, 4)), 0.0, 0.0,
    ),
]  # fmt: skip
