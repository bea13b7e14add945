"""The same Euler steps by others: x <- x + h (-x + A*clip(x) + w), zeros around, float32. A peer not installed is left
out and named.
"""

from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

Array = NDArray[np.float32]
Run = Callable[[], object]


def jax(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """The whole loop compiled, shifted slices."""
    jax, jnp = import_module("jax"), import_module("jax.numpy")

    rows, cols = x.shape

    def loop(x: Any, w: Any) -> Any:
        def step(_: int, x: Any) -> Any:
            y = jnp.pad(jnp.clip(x, -1, 1), 1)
            total = w
            for (k, l), c in np.ndenumerate(a):
                total = total + c * y[k : k + rows, l : l + cols]
            return x + np.float32(h) * (total - x)

        return jax.lax.fori_loop(0, steps, step, x)

    run, start, drive = jax.jit(loop), jnp.array(x), jnp.array(w)
    return lambda: run(start, drive).block_until_ready()


def torch(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """A loop over conv2d."""
    torch = import_module("torch")

    kernel, drive, start = torch.tensor(a)[None, None], torch.tensor(w)[None, None], torch.tensor(x)[None, None]

    def run() -> None:
        state = start
        for _ in range(steps):
            state = state + h * (torch.nn.functional.conv2d(state.clamp(-1, 1), kernel, padding=1) + drive - state)

    return run


def opencv(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """A loop over filter2D."""
    cv2 = import_module("cv2")

    def run() -> None:
        state = x
        for _ in range(steps):
            total = cv2.filter2D(np.clip(state, -1, 1), -1, a, borderType=cv2.BORDER_CONSTANT)
            state = state + np.float32(h) * (total + w - state)

    return run


def scipy(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """A loop over ndimage.correlate."""
    from scipy.ndimage import correlate

    def run() -> None:
        state = x
        for _ in range(steps):
            total = correlate(np.clip(state, -1, 1), a, mode="constant")
            state = state + np.float32(h) * (total + w - state)

    return run


def _loops(x: Array, out: Array, w: Array, a: Array, h: np.float32) -> None:
    one = np.float32(1)
    for i in prange(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            total = w[i, j]
            for k in range(3):
                for l in range(3):
                    total += a[k, l] * min(max(x[i + k - 1, j + l - 1], -one), one)
            out[i, j] = x[i, j] + h * (total - x[i, j])


_plain = njit(parallel=True, fastmath=True)(_loops)


def numba_loop(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """What one writes first: three nested loops, the outer one in parallel."""
    padded, drive = np.pad(x, 1), np.pad(w, 1)
    other = np.zeros_like(padded)

    def run() -> None:
        source, target = padded, other
        for _ in range(steps):
            _plain(source, target, drive, a, np.float32(h))
            source, target = target, source

    return run


def celnn(x: Array, w: Array, a: Array, h: float, steps: int) -> Run:
    """CellularNetwork of the package celnn, on NumPy; the input carries w."""
    package = import_module("celnn")
    centre = np.zeros((3, 3))
    centre[1, 1] = 1.0
    settings = package.SimulationConfig(t_end=h * steps, dt=h, stability_checks=False)

    def run() -> None:
        package.CellularNetwork(w, x, a, centre, 0.0, dtype=np.float32).run(settings)

    return run


PACKAGES = {"jax": jax, "torch": torch, "cv2": opencv, "scipy": scipy, "numba": numba_loop, "celnn": celnn}


def installed(*, fast_only: bool) -> Iterator[tuple[str, Callable[..., Run]]]:
    """Yield the peers that are there; the slow ones are left out where they would take minutes."""
    for package, peer in PACKAGES.items():
        if find_spec(package) and not (fast_only and package in ("scipy", "celnn", "torch")):
            yield peer.__name__, peer


def missing() -> list[str]:
    """Return the packages that are not installed."""
    return [package for package in PACKAGES if not find_spec(package)]
