"""Padded planes of a network on the device, and the tasks that its kernels do in them (kernels/network.cl)."""

from collections.abc import Iterator, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.opencl.device.build import Defines
from cnnsim.backends.opencl.device.context import Buffer, DeviceContext
from cnnsim.backends.opencl.padded import PaddedPlanes
from cnnsim.backends.opencl.planes import DeviceGrid
from cnnsim.backends.opencl.term_text import term_defines
from cnnsim.backends.slices import TERM
from cnnsim.backends.term_table import TermTable, characteristic
from cnnsim.network import layered
from cnnsim.planning.plan import Plan


class NetworkTask(Enum):
    """A kernel of network.cl, with its definition."""

    OUTPUT = "PLAIN(output, OUTPUT_TASK) "
    DRIVE = "PLAIN(drive, DRIVE) "
    STEP = "PLAIN(step_network, STEP) "
    DISCRETE = "PLAIN(discrete, DISCRETE) "
    CHECK = "MEASURED(check, CHECK) "
    CHECK_DISCRETE = "MEASURED(check_discrete, DISCRETE) "

    @property
    def kernel(self) -> str:
        """The name of the kernel."""
        return self.value.partition("(")[2].partition(",")[0]


class Neighbours(NamedTuple):
    """The neighbours' part of a drive: kernels/<stem>.cl, its definitions and arguments, and its sums a cell."""

    stem: str
    defines: Defines
    arguments: tuple[Any, ...]
    sums: int


def of_terms(
    context: DeviceContext, plan: Plan, table: TermTable, delays: Sequence[int], *, output: bool = True
) -> Neighbours:
    """Return the terms of a table; ``output``: with the plan's output characteristic."""
    layers = len(plan.network.layers) if plan.network else 1
    f = characteristic(plan, context.dtype) if output else None
    weights = context.table(np.append(table.planes.ravel(), np.zeros(context.lanes, context.dtype)))
    defines = term_defines(table, layers, f, delays, context.dtype)
    return Neighbours("terms", defines, (weights,), TERM * max(1, len(table.taps.k)))


def of_taps(context: DeviceContext, plan: Plan, stride: int) -> Neighbours:
    """Return the taps of a linear template."""
    taps = plan.feedback_taps
    offsets = np.array([tap.k * stride + tap.l for tap in taps] or [0], np.int32)
    weights = np.array([tap.weight for tap in taps] or [0.0], context.dtype)
    return Neighbours("taps", {}, (*map(context.table, (offsets, weights)), np.int32(len(taps))), len(taps))


class NetworkPlanes:
    """The padded planes of a run, and the launch of tasks in them; see network.cl.

    Arguments: ``delay`` [steps], the longest with which terms read states and outputs, None where there is only the
    drive of the input; ``inputs``, planes of the input; ``z`` of each layer.
    """

    def __init__(
        self, context: DeviceContext, plan: Plan, grid: DeviceGrid, radius: int, *, delay: int | None = 0,
        inputs: int = 0, z: Sequence[float] = (0.0,), mask: Buffer | None = None,
    ) -> None:  # fmt: skip
        self._context, self._plan, self._mask = context, plan, mask
        network, scheme = layered(plan.template) if plan.network is None else plan.network, plan.scheme
        stages = len(scheme.b) if scheme else 1
        self.padded = padded = PaddedPlanes(context, grid, len(network.layers), radius, plan.boundary)
        self.stages, self.past = stages, (delay or 0) + 2 if delay or stages == 1 else 1
        self.w, of_states = padded.new(1), self.past + min(2, stages - 1)
        self.x = padded.new(of_states) if delay is not None else self.w
        self.y = padded.new(of_states) if delay is not None and plan.cell != "discrete-time" else self.x
        self.u = padded.new(inputs) if inputs else self.x
        keeps = scheme is not None and scheme.keeps_rates
        self._sums = padded.new(1 + keeps * stages) if stages > 1 else self.w
        gain = scheme.gain(plan.step) if scheme and plan.network is None else 1.0
        numbers = [0.0] if scheme is None else [*scheme.matrix[1:].ravel(), *np.zeros(stages), *scheme.b]
        self._table = context.table((gain * np.array(numbers)).astype(context.dtype))
        self._over = [1 / time for time in network.time_constants]
        gains = [scheme.gain(plan.step * rate) if scheme and plan.network else 1.0 for rate in self._over]
        self._gains, self._outside = self._numbers(gains), context.dtype.type(plan.boundary.y)
        self._z = z
        self._defines: Defines = {
            **padded.defines, "RADIUS": radius, "STAGES": stages, "PAST": self.past, "KEEPS": int(keeps),
            "AHEAD": sum(round(sum(row)) << stage for stage, row in enumerate(scheme.a)) if scheme else 0,
            "LIMITED": int(plan.cell == "full-range"), "OUTPUTS": int(plan.cell != "discrete-time"),
            **({} if mask is None else {"MASK": ""}),
        }  # fmt: skip

    def _numbers(self, numbers: Sequence[float]) -> Buffer:
        return self._context.table(np.array(numbers, self._context.dtype))

    def set_bias(self, bias: Buffer | None) -> None:
        """Set the drive to a bias map, or to 0."""
        if bias is None:
            self._context.clear(self.w, self.w.size // 8 * 8)
        else:
            self.padded.pad(bias, self.w, 0, 0.0)

    def do(self, task: NetworkTask, neighbours: Neighbours, step: int = 0, first_turn: int = 0, turns: int = 1) -> None:
        """Do a task at ``step``, or ``turns`` stages of steps from there on."""
        for _ in self._launches(task, neighbours, step, first_turn, turns):
            pass

    def measure(self, task: NetworkTask, neighbours: Neighbours, step: int) -> tuple[float, bool]:
        """Do a task; return the largest rate or change, and whether a cell's flag is set."""
        dtype = self._context.dtype
        found = [self._context.parts(2 * parts, dtype) for parts in self._launches(task, neighbours, step, 0, 1)]
        largest, flag = np.concatenate(found).reshape(-1, 2).max(axis=0)
        return float(largest), bool(flag)

    def _launches(
        self, task: NetworkTask, neighbours: Neighbours, step: int, first_turn: int, turns: int
    ) -> Iterator[int]:
        """Launch a task piece by piece, and yield how many parts the measures of each piece have."""
        context, padded = self._context, self.padded
        defines = {**self._defines, **neighbours.defines, "KERNELS": task.value}
        kernel = context.kernel(task.kernel, f"boundary ghosts {neighbours.stem} network", defines)
        of_layer = self._numbers(self._z if task is NetworkTask.DRIVE else self._over)
        cells = padded.cells * (turns if padded.whole else 1)
        for first, units in context.pieces(padded.units, turns * neighbours.sums * padded.cells / padded.units):
            yield context.launch(
                kernel, cells * units // padded.units, self.x, self.y, self.u, self.w, self._sums, self._mask,
                context.partial, self._table, self._gains, of_layer, self._outside,
                *map(np.int32, (step, first_turn, turns)), *padded.arguments, *map(np.int32, (first, units)),
                *neighbours.arguments,
            )  # fmt: skip
