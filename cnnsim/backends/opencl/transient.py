"""The time loops of the OpenCL backend: they launch, the device computes, and only looks come back."""

import math
from typing import Any

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.build import Workshop, boundary_defines, literal, radius_of, tap_defines
from cnnsim.backends.opencl.settled import Buffer, Shape, Watch, stencil_arguments, walls
from cnnsim.backends.opencl.tiles import cut
from cnnsim.planning.plan import Plan


def drive(shop: Workshop, plan: Plan, shape: Shape, u: Buffer | None, bias: Buffer | None) -> Buffer:
    """Return w = z + bias + B*u."""
    grids, rows, cols = shape
    heard = plan.template.control_taps if u is not None else ()
    w = shop.buffer(grids * rows * cols * shop.dtype.itemsize)
    shop.run(
        shop.kernel("control", "stencil", {**boundary_defines(plan.boundary), "CONTROL": ""}), grids * rows * cols,
        u, bias, w, shop.dtype.type(plan.template.z), np.int32(bias is not None),
        *stencil_arguments(shop, heard, plan.boundary.u, shape),
    )  # fmt: skip
    return w


def closed_form(shop: Workshop, plan: Plan, shape: Shape, x: Buffer, w: Buffer, held: Buffer | None) -> Buffer:
    """Return the states of uncoupled cells at the end of the plan's duration."""
    grids, rows, cols = shape
    rest, number = plan.duration == "settled", shop.dtype.type
    t = 0.0 if plan.duration == "settled" else plan.duration
    out = shop.buffer(x.size)
    shop.run(
        shop.kernel("closed_form", "closed", walls(plan)), grids * rows * cols, x, w, held, out,
        number(plan.template.self_feedback), number(t),
        np.int32(rest), np.int32(held is not None), np.int64(grids * rows), np.int32(cols),
    )  # fmt: skip
    return out


class Steps:
    """Steps of a one-stage scheme from the state ``x``, which is left as it is: several a launch, ping and pong.

    With the saving "sleep", tiles are left out in which the launch before, of as many steps, changed no bit (see
    opencl_sleep.cl); the first two launches step all of them, since each plane has to be filled once.
    """

    def __init__(self, shop: Workshop, plan: Plan, shape: Shape, x: Buffer, w: Buffer, held: Buffer | None) -> None:
        assert plan.scheme is not None
        self.x, self._shop, self._w, self._held = x, shop, w, held
        stretch = min(plan.steps, plan.check_every) if plan.duration == "settled" else plan.steps
        stretch = stretch if "blocking" in plan.savings else 1
        taps = tap_defines(plan.feedback_taps, plan.boundary, plan.boundary.y, shop.dtype)
        sleep, torus = "sleep" in plan.savings, plan.boundary.kind == "periodic"
        self._tiles = cut(shop, shape, radius_of(plan.feedback_taps), torus, stretch, sleep)
        defines = {
            **taps, **walls(plan), **_shared_sums(shop, plan), **({} if held is None else {"HELD": ""}),
            **({"SLEEP": ""} if sleep else {}),
            "GAIN": literal(plan.scheme.gain(plan.step) * plan.scheme.b[0], shop.dtype), **self._tiles.defines,
        }  # fmt: skip
        self._kernels = [shop.kernel("steps", f"sleep {shop.family}", defines, twin=twin) for twin in (0, 1)]
        self._planes: list[Buffer] = []
        self._moved = [shop.buffer(self._tiles.groups) for _ in (0, 1)] if sleep else []
        self._bound: list[tuple[Buffer, int, bool] | None] = [None, None]
        self._turn, self._launches, self._last = 0, 0, 0

    def advance(self, steps: int) -> None:
        """Go so many steps on."""
        while steps > 0:
            now = min(steps, self._tiles.most_steps)
            turn = self._turn
            if len(self._planes) == turn:
                self._planes.append(self._shop.buffer(self.x.size))
            fresh = self._launches < 2 or now != self._last
            if self._bound[turn] != (self.x, now, fresh):
                sleep: tuple[Any, ...] = (*self._moved[:: 2 * turn - 1], np.int32(fresh)) if self._moved else ()
                self._kernels[turn].set_args(
                    self.x, self._w, self._held, self._planes[turn], *self._tiles.arguments, np.int32(now), *sleep
                )
                self._bound[turn] = self.x, now, fresh
            cl.enqueue_nd_range_kernel(
                self._shop.queue, self._kernels[turn], self._tiles.global_size, self._tiles.local_size
            )
            self.x, self._turn = self._planes[turn], 1 - turn
            self._launches, self._last = self._launches + 1, now
            steps -= now

    def finish(self) -> Buffer:
        """Return the last state; the other plane may be used for something else."""
        self._shop.recycle(*(plane for plane in self._planes if plane is not self.x))
        return self.x


class Stages:
    """Steps of a scheme of several stages: two launches a stage, one more a step."""

    def __init__(self, shop: Workshop, plan: Plan, shape: Shape, x: Buffer, w: Buffer, held: Buffer | None) -> None:
        assert plan.scheme is not None
        grids, rows, cols = shape
        self.x, self._shop, self._w, self._held, self._scheme = x, shop, w, held, plan.scheme
        self._gain = plan.scheme.gain(plan.step)
        self._cells = grids * rows * cols
        self._lines = np.int64(grids * rows), np.int32(cols)
        self._stencil = stencil_arguments(shop, plan.feedback_taps, plan.boundary.y, shape)
        self._slope = shop.kernel("slope", "stencil", {**boundary_defines(plan.boundary), "SLOPE": ""})
        self._update = shop.kernel("update", "update", walls(plan))
        self._slopes = [shop.buffer(x.size) for _ in plan.scheme.b]
        self._stage = shop.buffer(x.size)
        self._mine = False  # whether x may be written over

    def advance(self, steps: int) -> None:
        """Go so many steps on."""
        for _ in range(steps):
            for row, slope in zip(self._scheme.a, self._slopes, strict=True):
                self._sum(row, self._stage, None)
                self._shop.run(self._slope, self._cells, self._stage, self._w, slope, *self._stencil)
            to = self.x if self._mine else self._shop.buffer(self.x.size)
            self._sum(self._scheme.b, to, self._held)
            self.x, self._mine = to, True

    def finish(self) -> Buffer:
        """Return the last state."""
        return self.x

    def _sum(self, weights: tuple[float, ...], to: Buffer, held: Buffer | None) -> None:
        """Write wall(x + sum of gain * weight * slope) to a plane."""
        slopes = [*self._slopes[: len(weights)], *[None] * (4 - len(weights))]
        factors = [self._shop.dtype.type(self._gain * weight) for weight in (*weights, 0.0, 0.0, 0.0, 0.0)[:4]]
        self._shop.run(
            self._update, self._cells, self.x, *slopes, held, to, *factors, np.int32(len(weights)),
            np.int32(held is not None), *self._lines,
        )  # fmt: skip


def stepped(
    shop: Workshop, plan: Plan, shape: Shape, x: Buffer, w: Buffer, held: Buffer | None
) -> tuple[Buffer, int, bool, float]:
    """Return the state at the end, the steps taken, whether the network settled and the largest |dx/dt|."""
    assert plan.scheme is not None
    road: Steps | Stages = (Steps if len(plan.scheme.b) == 1 else Stages)(shop, plan, shape, x, w, held)
    if plan.duration != "settled":
        road.advance(plan.steps)
        return road.finish(), plan.steps, False, math.nan
    done, watch = 0, Watch(shop, plan, shape, w, held)
    while True:
        settled, steepest = watch.look(road.x, whole=done == plan.steps)
        if settled or done == plan.steps:
            return road.finish(), done, settled, steepest
        now = min(plan.check_every, plan.steps - done)
        road.advance(now)
        done += now


def _shared_sums(shop: Workshop, plan: Plan) -> dict[str, str | int]:
    """Definitions for isotropic templates of radius 1; not in float64, which keeps the reference's order of sums."""
    if "shared sums" not in plan.savings or shop.family != "cpu" or shop.dtype != np.float32:
        return {}
    names = {"CENTRE": (1, 1), "EDGE": (0, 1), "CORNER": (0, 0)}
    A: Any = plan.template.A
    return {"SHARED_SUMS": "", **{name: literal(A[at], shop.dtype) for name, at in names.items()}}
