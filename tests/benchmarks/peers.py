"""The same Euler steps by other packages: x <- x + h (-x + A*clip(x) + w), zeros around, float32."""

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
    """Three nested loops, the outer one in parallel."""
    padded, drive = np.pad(x, 1), np.pad(w, 1)
    other = np.zeros_like(padded)

    def run() -> None:
        source, target = padded, other
        for _ in range(steps):
            _plain(source, target, drive, a, np.float32(h))
            source, target = target, source

    return run


PACKAGES = {"jax": jax, "scipy": scipy, "numba": numba_loop}


def installed(*, fast_only: bool) -> Iterator[tuple[str, Callable[..., Run]]]:
    """Yield the installed peers, without scipy where it would take minutes."""
    for package, peer in PACKAGES.items():
        if find_spec(package) and not (fast_only and package == "scipy"):
            yield peer.__name__, peer


def missing() -> list[str]:
    """Return the packages that are not installed."""
    return [package for package in PACKAGES if not find_spec(package)]
