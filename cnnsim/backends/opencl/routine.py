"""Routines of programs on small grids in one launch: a work-group a grid, planes in local memory (routine.cl)."""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.device.build import literal
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.opencl.planes import WORD, DevicePlane, words_of
from cnnsim.backends.opencl.routine_tables import COLUMNS, TRANSFERS, Place, RoutineTables
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.routine import Op, Routine, Stores
from cnnsim.planning.plan import SETTLED_RATE

LOCAL_BYTES, INPUTS = 32 * 1024, 16
"""Local memory of the planes of a grid, and the most planes that a routine is given."""
MOST_CELLS, MOST_STEPPED_CELLS = {"cpu": 1024, "gpu": 4096}, {"cpu": 256, "gpu": 4096}
"""Cells of a grid, and of one with time loops, by the family: on a CPU larger ones are faster step by step."""
PREFETCHED = 1 << 16
"""Bytes of results up to which all are read in one transfer."""


def fits(routine: Routine, family: str) -> bool:
    """Return whether a routine can run in one launch, if the local memory is large enough."""
    cells = math.prod(routine.shape[-2:])
    for op, *_, by in routine.instructions:
        if (op is Op.STEPS and cells > MOST_STEPPED_CELLS[family]) or (op is Op.NUMBER and abs(by) >= 1 << 30):
            return False
        if op in (Op.SETTLE, Op.STEPS) and by.cell != "chua-yang":
            return False
    return cells <= MOST_CELLS[family] and len(routine.given.llm) + len(routine.given.lam) <= INPUTS


class DeviceRoutine:
    """A routine on a device; called with planes and registers it returns its results.

    It returns None where a result is not finite or too large for a register, or where a transient does not end
    saturated. Run one by one, the steps then raise the error, or find the rest.
    """

    def __init__(self, context: DeviceContext, routine: Routine) -> None:
        self._context, self._routine = context, routine
        self._grids, (self._rows, self._cols) = math.prod(routine.shape[:-2]), routine.shape[-2:]
        size, align = context.dtype.itemsize, max(8, context.device.mem_base_addr_align // 8)
        self._tables = tables = RoutineTables(routine, size, align)
        self._cells, slots = self._rows * self._cols, tables.slots
        lam = slots["lam"] + 2 * any(instruction.op is Op.STEPS for instruction in routine.instructions)
        self._local = lam * self._cells * size, slots["llm"] * self._cells, 8 * slots["wire"]
        self.fits = sum(self._local) <= LOCAL_BYTES and tables.size < 1 << 31

    @cached_property
    def _constants(self) -> tuple[Any, ...]:
        context, tables = self._context, self._tables
        code, table = np.array(tables.code, np.int32), np.array(tables.table, np.int32)
        numbers = context.table(np.array(tables.numbers, context.dtype))
        local = [cl.LocalMemory(max(8, size)) for size in self._local]
        return context.table(code), np.int32(len(code)), context.table(table), numbers, *local

    @cached_property
    def _kernel(self) -> cl.Kernel:
        defines: dict[str, str | int] = {
            **{f"OP_{op.name}": int(op) for op in Op}, **{f"OP_{name}": code for name, code in TRANSFERS.items()},
            "COLUMNS": COLUMNS, "BOUNDARY": 0, "LIMITED": 0, "REST": 1,
            "SETTLED_RATE": literal(SETTLED_RATE, self._context.dtype),
        }  # fmt: skip
        operations = _cellwise_text(self._tables.operations)
        return self._context.kernel("routine", "boundary closed routine", defines, extra=operations)

    def __call__(self, given: Stores) -> Stores | None:
        """Return the planes and registers that are results."""
        context, results = self._context, self._routine.results
        with context.lock:
            out, wires = context.buffer(self._tables.size), None
            if given.wire:
                numbers = np.array([np.broadcast_to(n, self._grids) for n in given.wire], np.int64)
                wires = context.load(numbers, cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR)
            planes = [plane.buffer for plane in (*given.llm, *given.lam)]
            most = min(64 if self._cells <= 64 else 256, context.device.max_work_group_size)
            items = 1 if context.family == "cpu" else most
            for first, count in context.pieces(self._grids, self._tables.work):
                numbers = np.array([self._rows, self._cols, self._grids, first, self._tables.slots["lam"]], np.int32)
                context.enqueue(
                    self._kernel, (count * items,), (items,), *planes, *[None] * (INPUTS - len(planes)), wires, out,
                    *self._constants, *numbers,
                )  # fmt: skip
            ends = [4 * self._grids, *(self._tables.stored["wire", n] + 8 * self._grids for n in results.wire)]
            end = self._tables.size if self._tables.size <= PREFETCHED else max(ends)
            host = context.read(out, np.empty(end, np.uint8))
        if host[: 4 * self._grids].any():
            return None
        return Stores(
            [self._plane(out, host, ("llm", n)) for n in results.llm],
            [self._plane(out, host, ("lam", n)) for n in results.lam],
            [self._register(host, n) for n in results.wire],
        )

    def _register(self, host: np.ndarray[Any, Any], n: int) -> Any:
        begin = self._tables.stored["wire", n]
        numbers = host[begin : begin + 8 * self._grids].view(np.int64)
        return numbers.copy() if len(self._routine.shape) == 3 else int(numbers[0])

    def _plane(self, out: Any, host: np.ndarray[Any, Any], place: Place) -> DevicePlane:
        """Return a result as a part of the buffer of all results, with its copy on the host if there is one."""
        memory, begin, shape = place[0], self._tables.stored[place], self._routine.shape
        llm = memory == "llm"
        row, dtype = (
            (words_of(self._cols) * WORD // 8, np.dtype(np.uint8)) if llm else (self._cols, self._context.dtype)
        )
        size = self._grids * self._rows * row * dtype.itemsize
        part = cast(cl.Buffer, cl.Buffer.from_int_ptr(out.int_ptr, True)).get_sub_region(begin, size)
        copied = host[begin : begin + size].view(dtype).reshape(*shape[:-1], row) if begin + size <= len(host) else None
        return DevicePlane(part, shape, memory, host=copied, whole=out)  # type: ignore[arg-type]  # llm or lam


def _cellwise_text(operations: Sequence[Cellwise]) -> str:
    """Return the function ``cellwise`` of routine.cl: one loop over the cells for each operation."""
    text = ""
    for which, operation in enumerate(operations):
        names = [*operation.inputs, *operation.outputs]
        plane = {name: f"LAM(slots[{3 * i + 2}])[cell]" for i, name in enumerate(names)}
        lines = [f"if (which == {which}) {{"]
        lines += [f"const real {name} = numbers[{i}];" for i, name in enumerate(operation.parameters)]
        lines += ["EACH_LOCAL(cell, cells) {", *(f"const real {n} = {plane[n]};" for n in operation.inputs)]
        lines += [*(f"real {name};" for name in operation.outputs), operation.opencl]
        lines += [*(f"{plane[name]} = {name};" for name in operation.outputs), "}", "}"]
        text += "\n".join(lines) + "\n"
    head = "static void cellwise(int which, __local real *lam, __global const int *slots, "
    return f"{head}__global const real *numbers, int cells)\n{{\n{text}}}\n"
