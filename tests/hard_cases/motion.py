"""Hard motions: chaos, oscillations, a million steps of a turning mode, and the same bytes in every run."""

import subprocess
import sys
from typing import Any

import mpmath
import numpy as np

from cnnsim import LayeredTemplate, Template, Term, fixed, run_transient
from cnnsim.backends.base import Backend
from cnnsim.support import Array
from tests.hard_cases.case import HardCase
from tests.hard_cases.dense_flow import dense_flow

EDGE = fixed(0)
TURN = np.array([[0, 0, 0], [-1.2, 2, 1.2], [0, 0, 0]])
PAIR = np.array([[2, 1.2], [-1.2, 2]])
"""TURN as the matrix of two cells in a row."""
NINE = np.array([[0.1, 0.3, -0.2], [0.4, 1.5, 0.1], [-0.3, 0.2, 0.1]])


def _run(template: Any, x: Array, duration: float, **more: Any) -> Any:
    def ours(backend: Backend) -> Array:
        return run_transient(template, state=x, duration=duration, backend=backend, **more).x

    return ours


def _cycle(t: float) -> HardCase:
    x = np.array([[0.1, 0.0]])
    return HardCase(
        f"limit cycle, t = {t:g}", "the cycle does not damp phase errors, so they accumulate",
        _run(Template(TURN), x, t, boundary=EDGE, accuracy=1e-6),
        lambda: dense_flow(PAIR, np.zeros(2), x[0], t)[None], 1e-6, 1e-6,
        lambda: _euler_pair(x, t, 0.1),
    )  # fmt: skip


def _euler_pair(x: Array, t: float, h: float) -> Array:
    x = x[0].copy()
    for _ in range(round(t / h)):
        x = x + h * (PAIR @ x.clip(-1, 1) - x)
    return x[None]


CHAOS = np.array([[1.25, -3.2, -3.2], [-3.2, 1.1, -4.4], [-3.2, 4.4, 1.0]])
"""Three cells of Zou and Nossek, IEEE Trans. CAS-I 40 (1993) 166: y = clip(x), no input; chaotic."""


def _chaos() -> HardCase:
    """Three layers of one cell each."""
    layers = [
        Template(CHAOS[i, i], terms=[Term([[CHAOS[i, j]]], "y_kl", layer=j) for j in range(3) if j != i])
        for i in range(3)
    ]
    x, t = np.array([0.1, 0.1, 0.1]).reshape(3, 1, 1), 12.0
    return HardCase(
        "chaos of three cells", "nearby states diverge exponentially, so the error of each step grows",
        _run(LayeredTemplate(layers), x, t, boundary=EDGE, scheme="rk4", step=0.0005),
        lambda: _chaotic(x, t), 1e-5, 0.02,
        lambda: _euler_three(x, t, 0.1), page=True,
    )  # fmt: skip


def _euler_three(x: Array, t: float, h: float) -> Array:
    x = x.ravel().copy()
    for _ in range(round(t / h)):
        x = x + h * (CHAOS @ x.clip(-1, 1) - x)
    return x.reshape(3, 1, 1)


def _chaotic(x: Array, t: float) -> Array:
    return dense_flow(CHAOS, np.zeros(3), x.ravel(), t).reshape(3, 1, 1)


def _turning() -> HardCase:
    """10^6 rk4 steps of a mode that only turns, exp(i t / 4): |R(i h / 4)| = 1 - (h / 4)^6 / 144 a step."""
    h, steps, rate = 0.05, 1_000_000, 0.25
    A = np.array([[0, 0, 0], [-rate, 1, rate], [0, 0, 0]])
    x = np.array([[0.5, 0.0]])

    def turned() -> Array:
        with mpmath.workdps(40):
            z = mpmath.mpc(0, -rate * h)
            growth = (1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) ** steps * mpmath.mpf(0.5)
            return np.array([[float(growth.real), float(growth.imag)]])

    return HardCase(
        "10^6 steps of a turning mode", "no mode decays: the rounding error of each step remains",
        _run(Template(A), x, h * steps, boundary=EDGE, scheme="rk4", step=h), turned, 1e-9, 0.02,
        lambda: _float32_turns(x, A, h, steps), slow=True,
    )  # fmt: skip


def _float32_turns(x: Array, A: Array, h: float, steps: int) -> Array:
    """Euler in float32, with a twentieth of the steps: the amplitude grows by (h / 4)^2 / 2 in each."""
    a, b, rate = np.float32(x[0, 0]), np.float32(0), np.float32(A[1, 2] * h)
    for _ in range(steps // 20):
        a, b = a + rate * b, b - rate * a
    return np.array([[float(a), float(b)]])


def _same(name: str, why: str, one: Any, other: Any, *, slow: bool = False, page: bool = False) -> HardCase:
    """A case whose answer is another run of ours: the same bytes are wanted."""
    return HardCase(name, why, one, None, 0.0, 0.0, slow=slow, page=page, again=other)


def _start(shape: tuple[int, int] = (40, 37)) -> Array:
    return np.random.default_rng(11).uniform(-1, 1, shape)


def _threads(number: int) -> Any:
    def ours(backend: Backend) -> Array:
        where: Any = {"threads": number, "dtype": str(backend.dtype)} if backend.name == "cpu" else {"backend": backend}
        return run_transient(Template(NINE), state=_start((150, 160)), duration=3.0, **where).x

    return ours


def _elsewhere(backend: Backend) -> Array:
    """The same transient in a new process."""
    code = (
        "import sys, numpy as np\n"
        "from cnnsim import Template, run_transient\n"
        "from tests.hard_cases.motion import NINE, _start\n"
        f"x = run_transient(Template(NINE), state=_start(), duration=3.0, backend={backend.name!r},"
        f" dtype={str(backend.dtype)!r}).x\n"
        "sys.stdout.buffer.write(x.tobytes())\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    return np.frombuffer(done.stdout, backend.dtype).reshape(_start().shape)


CASES = [
    _cycle(40.0), _chaos(), _turning(),
    _same(
        "the same bytes again", "sums in another order round differently",
        _run(Template(NINE), _start(), 3.0), _run(Template(NINE), _start(), 3.0),
    ),
    _same(
        "the same bytes by 1 and 2 threads", "two threads process the tiles in another order",
        _threads(1), _threads(2), slow=True,
    ),
    _same(
        "the same bytes in another process", "hash seeds, caches and builds differ",
        _run(Template(NINE), _start(), 3.0), _elsewhere, page=True,
    ),
]  # fmt: skip
