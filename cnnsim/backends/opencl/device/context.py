"""A device's context: its queue, its buffers, its built programs and how a kernel is launched."""

import ctypes
import os
from collections import deque
from collections.abc import Iterator
from functools import cache
from threading import RLock
from time import sleep
from typing import Any
from weakref import finalize

import numpy as np
import pyopencl as cl

from cnnsim.backends.opencl.device.build import Defines, build, code_defines, define_lines, source
from cnnsim.backends.opencl.device.devices import Family, check_not_forked
from cnnsim.backends.opencl.device.pages import LEAST, ask_for_large_pages, works_in_memory
from cnnsim.backends.opencl.device.pocl import has_wide_vectors, name_processor
from cnnsim.backends.slices import pieces

Buffer = cl.Buffer

GROUP = 256
"""Work-items of a group in the kernels that go over cells one by one on a GPU."""

LANES = 8
"""Numbers in a vector on a CPU, at least the largest radius."""

WIDE_LANES = 16
"""float32 in a vector where registers are that wide: half as fast again. Where they are not, it is 5 % slower."""

LEAST_CELLS = 4096
"""Cells of a work-item at least, on a CPU: waking a thread takes longer than fewer."""

POLL = 1e-4
"""Seconds between two looks whether a kernel's first launch is over."""

POOLED = 4
"""Buffers kept for the next transient (its drive, and the two states between which steps go) or the next loads."""


_CONTEXTS: list["DeviceContext"] = []


class _Lock:
    """A lock for one thread at a time; whoever leaves it by an error waits until nothing runs in what is then freed."""

    def __init__(self, queue: cl.CommandQueue) -> None:
        self._lock, self._queue = RLock(), queue

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, error: object, *_: object) -> None:
        try:
            if error is not None:
                self._queue.finish()
        finally:
            self._lock.release()


class DeviceContext:
    """One device with its context, its queue and its built programs, for one dtype and one family of kernels.

    Its kernels keep the arguments they were given last, so whoever launches holds the ``lock`` from the first argument
    to the last launch: setting arguments is the one OpenCL call that threads may not make at once (OpenCL 1.2, app. A).
    """

    def __init__(self, device: cl.Device, family: Family, dtype: np.dtype[Any]) -> None:
        self.device, self.family, self.dtype = device, family, dtype
        self.context, self.queue, self._side_queue = _context_and_queues(device)
        self.lock = _Lock(self.queue)
        wide = dtype == np.float32 and has_wide_vectors(device)
        self.lanes = (WIDE_LANES if wide else LANES) if family == "cpu" else 1
        self.cores = device.max_compute_units
        kind: Defines = {"DOUBLE": "", "REAL": "double"} if dtype == np.float64 else {"REAL": "float"}
        here: Defines = {"CPU": ""} if family == "cpu" else {"GROUP": GROUP}
        self._basics = define_lines({**kind, **here, "V": self.lanes, **code_defines()})
        self._most_parts = 4 * (self.cores if family == "cpu" else GROUP)  # of a sum over a plane
        self.partial = self.new(2 * 8 * self._most_parts)
        self._scratch: Buffer | None = None
        self._lent: dict[int, finalize[Any, Any]] = {}
        self._pool: deque[Buffer] = deque(maxlen=POOLED)
        self._tables: dict[bytes, Buffer] = {}
        self._programs: dict[tuple[str, ...], cl.Program] = {}
        self._kernels: dict[tuple[str, ...], cl.Kernel] = {}
        self._numbers: dict[cl.Kernel, dict[int, bytes]] = {}  # that a kernel has as arguments
        self._compiled: set[cl.Kernel] = set()
        _CONTEXTS.append(self)

    def __getattr__(self, name: str) -> Any:
        """Say why nothing is left of a context after a fork; see `_leave_behind`."""
        check_not_forked(-1)
        raise AttributeError(name)

    def new(self, size: int) -> Buffer:
        """Return a new buffer of ``size`` bytes on the device."""
        buffer = cl.Buffer(self.context, cl.mem_flags.READ_WRITE, size)
        ask_for_large_pages(self._side_queue, buffer)
        return buffer

    def buffer(self, size: int) -> Buffer:
        """Return a new buffer of ``size`` bytes, or one that was given back."""
        kept = [self._pool.popleft() for _ in range(len(self._pool))]  # lent ones may come back meanwhile
        fits = next((pooled for pooled in kept if pooled.size == size), None)
        if fits is not None or size < LEAST:  # what a large grid has left goes before another one has its memory
            self._pool.extend(pooled for pooled in kept if pooled is not fits)
        return self.new(size) if fits is None else fits

    def recycle(self, *buffers: Buffer) -> None:
        """Take back buffers that nothing else refers to: new memory costs more than a few steps of the time loop."""
        self._pool.extend(buffers)

    def lend(self, plane: object, buffer: Buffer) -> None:
        """Take the large buffer of a plane back as soon as nobody has the plane any more, the only one that lies in it.

        The system empties new memory page by page: for 2048 x 2048 cells that takes longer than a closed form.
        """
        if buffer.size >= LEAST:
            self._lent[buffer.int_ptr] = taken = finalize(plane, self._take_back, buffer)
            taken.atexit = False

    def _take_back(self, buffer: Buffer) -> None:
        del self._lent[buffer.int_ptr]
        self._pool.append(buffer)

    def works_in(self, size: int) -> bool:
        """Return whether the device may work in this machine's own memory, where ``size`` bytes are worth it."""
        return size >= LEAST and works_in_memory(self.device)

    def hand_out(self, buffer: Buffer, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
        """Return a buffer as an array that lies in it: it is never taken back, and is there as long as the array."""
        if (lent := self._lent.pop(buffer.int_ptr, None)) is not None:
            lent.detach()
        return cl.enqueue_map_buffer(self.queue, buffer, cl.map_flags.WRITE, 0, shape, self.dtype)[0]

    def table(self, numbers: np.ndarray[Any, Any]) -> Buffer:
        """Return a few numbers on the device, to be read only; the same numbers are brought there once."""
        key = numbers.tobytes()
        if key not in self._tables:
            flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
            self._tables[key] = cl.Buffer(self.context, flags, hostbuf=numbers)
        return self._tables[key]

    def kernel(self, name: str, stems: str, defines: Defines, extra: str = "", twin: int = 0) -> cl.Kernel:
        """Return a kernel of kernels/<stem>.cl (of several, one after the other, and ``extra``) with these definitions.

        A kernel keeps its arguments, so those who need it with two sets of arguments ask for its ``twin`` as well.
        """
        lines = self._basics + define_lines(defines)
        key = (stems, lines, extra, f"{name} {twin}")
        if key not in self._kernels:
            if key[:-1] not in self._programs:
                text = lines + "".join(map(source, ["common", *stems.split()])) + extra
                self._programs[key[:-1]] = build(self.context, self.device, text, stems or name)
            self._kernels[key] = cl.Kernel(self._programs[key[:-1]], name)
        return self._kernels[key]

    def launch(self, kernel: cl.Kernel, work: int, *arguments: Any) -> int:
        """Launch a kernel that deals out ``work`` cells or words itself; return how many parts its sums have."""
        parts = self.workers(self._most_parts if self.family == "cpu" else -(-work // GROUP), work)
        self.launch_workers(kernel, parts, *arguments)
        return parts

    def workers(self, most: int, cells: int) -> int:
        """Return how many work-items, on a GPU work-groups, at the most share the work on so many cells."""
        return max(1, min(self._most_parts, most, cells // LEAST_CELLS if self.family == "cpu" else most))

    def launch_workers(self, kernel: cl.Kernel, workers: int, *arguments: Any) -> None:
        """Launch a kernel for so many work-items on a CPU, for as many work-groups on a GPU."""
        self.bind(kernel, *arguments)
        self.enqueue(kernel, *(((workers,), (1,)) if self.family == "cpu" else ((workers * GROUP,), (GROUP,))))

    def bind(self, kernel: cl.Kernel, *arguments: Any) -> None:
        """Set the arguments of a kernel; numbers that it has already are left, since pyopencl takes 3 us for each."""
        known = self._numbers.setdefault(kernel, {})
        for place, argument in enumerate(arguments):
            if not isinstance(argument, np.generic):
                kernel.set_arg(place, argument)
            elif known.get(place) != (number := argument.tobytes()):
                kernel.set_arg(place, argument)
                known[place] = number

    def scratch(self, size: int) -> Buffer:
        """Return a buffer of ``size`` bytes or more in which kernels work: one for all, which nobody keeps."""
        if self._scratch is None or self._scratch.size < size:
            self._scratch = self.new(size)
        return self._scratch

    def enqueue(self, kernel: cl.Kernel, *shape: Any) -> None:
        """Launch a kernel whose arguments are set; ``shape``: global and local sizes.

        No offset: PoCL would compile the kernel once more for it.
        """
        event = cl.enqueue_nd_range_kernel(self.queue, kernel, *shape)
        if kernel not in self._compiled:  # drivers compile at the first launch, for seconds: Python is to hear a signal
            self.queue.flush()
            while event.command_execution_status > cl.command_execution_status.COMPLETE:
                sleep(POLL)
            self._compiled.add(kernel)

    def pieces(self, count: int, work: float) -> Iterator[tuple[int, int]]:
        """Yield (first, count) of the pieces of so many rows or tiles with ``work`` sums in each; wait in between.

        The piece before the last is waited for, so that the device always has one to go on with.
        """
        parts = pieces(count, work, self.cores if self.family == "cpu" else 1)
        before: cl.Event | None = None
        for first, after in parts:
            yield first, after - first
            if len(parts) > 1:
                done = cl.enqueue_marker(self.queue)
                if before is not None:
                    before.wait()
                before = done

    def parts(self, count: int, dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
        """Read ``count`` numbers that a kernel left in ``partial``."""
        numbers = np.empty(count, dtype)
        cl.enqueue_copy(self.queue, numbers, self.partial)
        return numbers


@cache
def _context_and_queues(device: cl.Device) -> tuple[cl.Context, cl.CommandQueue, cl.CommandQueue]:
    """Return one context and queue a device, so that planes may go between backends, and a queue without kernels."""
    name_processor(device)
    context = cl.Context([device])
    return context, cl.CommandQueue(context), cl.CommandQueue(context)


def _leave_behind() -> None:
    """Empty all contexts in a child that was forked: their drivers' threads are not there, so nothing would ever end.

    What they held is never released, for the same reason.
    """
    for context in _CONTEXTS:
        held = vars(context).copy()
        vars(context).clear()
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(held))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_behind)

device_context = cache(DeviceContext)
"""The context of a device: one for all backends that want the same."""
