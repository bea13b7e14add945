"""Gradients against JAX on 200 random networks, and their cost: ``python -m tests.benchmarks.gradient``."""

from importlib import import_module
from importlib.util import find_spec
from time import process_time
from typing import Any

import numba
import numpy as np

from cnnsim import PERIODIC, Template, fixed, gradient
from cnnsim.backends import chosen
from cnnsim.learning.adjoint import AdjointTransient, weights_of
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import layered
from cnnsim.task import make_task

STEPS, STEP, SHAPE = 20, 0.1, (6, 7)


def by_jax(periodic: bool) -> Any:
    """Return the function of (A, B, z, bias, u, x0, target) with the gradients of the mean squared error."""
    jax, jnp = import_module("jax"), import_module("jax.numpy")
    jax.config.update("jax_enable_x64", True)

    def moved(plane: Any, weights: Any) -> Any:
        around = jnp.pad(plane, 1, mode="wrap" if periodic else "constant")
        rows, cols = plane.shape
        return sum(weights[k, l] * around[k : k + rows, l : l + cols] for k, l in np.ndindex(3, 3))

    def loss(*given: Any) -> Any:
        a, b, z, bias, u, x, target = given
        w = moved(u, b) + z + bias
        step = lambda x, _: (x + STEP * (moved(jnp.clip(x, -1, 1), a) + w - x), None)  # noqa: E731 - for scan
        return jnp.mean((jnp.clip(jax.lax.scan(step, x, None, STEPS)[0], -1, 1) - target) ** 2)

    return jax.jit(jax.grad(loss, argnums=range(6)))


def largest_difference(count: int = 200) -> float:
    """Return the largest relative difference from JAX over random networks."""
    found = []
    for periodic in (False, True):
        other = by_jax(periodic)
        for seed in range(count // 2):
            rng = np.random.default_rng(seed)
            a, b, z = rng.normal(size=(3, 3)) / 2, rng.normal(size=(3, 3)), rng.normal()
            bias, u, x, target = rng.uniform(-1, 1, (4, *SHAPE))
            entry = LibraryEntry("random", "", "", Template(a, b, z), initial_state="given")
            ours = gradient(
                entry, u, target, state=x, bias=bias, duration=STEPS * STEP, step=STEP, scheme="euler",
                boundary=PERIODIC if periodic else fixed(0),
            )  # fmt: skip
            assert isinstance(ours.template, Template)
            theirs = [np.asarray(part) for part in other(a, b, z, bias, u, x, target)]
            mine = [ours.template.A, ours.template.B, ours.template.z, ours.bias, ours.input, ours.state]
            found += [np.abs(m - t).max() / max(np.abs(t).max(), 1e-12) for m, t in zip(mine, theirs, strict=True)]
    return max(found)


def cost(shape: tuple[int, ...], dtype: Any) -> float:
    """Return the processor time of a gradient in transients, on one thread, the best of seven."""
    numba.set_num_threads(1)
    rng = np.random.default_rng(0)
    template = Template(rng.normal(size=(3, 3)) / 2, rng.normal(size=(3, 3)), 0.3)
    x, u = rng.uniform(-1, 1, (2, *shape))
    task = make_task(template, state=x, input=u, boundary=fixed(0.3), duration=10.0, scheme="euler", step=STEP)
    run, steps, backend = AdjointTransient(task, task.plan.steps, dtype), task.plan.steps, chosen("cpu", dtype, 1)
    weights, z, bar = weights_of(layered(template)), np.array([0.3]), np.ones_like(run.state)

    def both() -> None:
        run.forward(weights, z, (steps,))
        run.backward({steps: bar})

    best = []
    for work in (both, lambda: task.start(backend)):
        times = []
        for _ in range(8):  # the first compiles
            begun = process_time()
            work()
            times.append(process_time() - begun)
        best.append(min(times))
    return best[0] / best[1]


if __name__ == "__main__":
    for dtype in ("float64", "float32"):
        for shape in ((8, 32, 32), (256, 256)):
            print(f"{dtype}, {shape}: a gradient takes {cost(shape, dtype):.2g} transients")
    if find_spec("jax") is None:
        print("jax: not installed, not compared")
    else:
        print(f"largest relative difference from jax: {largest_difference():.2g}")
