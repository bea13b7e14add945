"""A device's context: its queue, its memory, its built programs, and the launch of kernels."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from threading import RLock
from time import sleep
from typing import Any, cast

import numpy as np
import pyopencl as cl
from pyopencl.tools import ImmediateAllocator, MemoryPool

from cnnsim.backends.opencl.device.build import Defines, build, code_defines, define_lines, source
from cnnsim.backends.opencl.device.counts import Counts
from cnnsim.backends.opencl.device.devices import Family, check_not_forked
from cnnsim.backends.opencl.device.kernel_cache import first_use
from cnnsim.backends.opencl.device.pocl import has_wide_vectors, name_processor
from cnnsim.backends.slices import pieces
from cnnsim.support import InputError
from cnnsim.support.memory import in_words

Buffer = cl.Buffer

GROUP = 256
"""Work-items of a group in the kernels that take cells one by one on a GPU."""

LANES, WIDE_LANES = 8, 16
"""Numbers in a vector on a CPU, at least the largest radius; float32 where registers are 512 bits wide."""

LEAST_CELLS = 4096
"""Fewest cells of a work-item on a CPU: to wake another thread for fewer takes longer."""

POLL = 1e-4
"""Seconds between two looks whether a kernel's first launch is over."""

IN_PLACE = 1 << 22
"""Bytes of a plane from which on a CPU device works in the caller's own memory instead of a copy."""

SPARE = 8
"""A large buffer is allocated with at most as many times its size in free buffers, of other sizes, in the pool."""

_CONTEXTS: list["DeviceContext"] = []


class _Lock:
    """A lock for one thread at a time; on an error it waits until no kernel runs in memory that is then freed."""

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
    """One device with its context, queue, memory pool and built programs, for one dtype and one family of kernels.

    A kernel keeps the arguments that it was given last, so a caller holds the ``lock`` while it launches: setting
    arguments is the one OpenCL call that is not thread-safe (OpenCL 1.2, app. A).
    """

    def __init__(self, device: cl.Device, family: Family, dtype: np.dtype[Any]) -> None:
        self.device, self.family, self.dtype = device, family, dtype
        self.context, self.queue, self._pool = _context_of(device)
        self.lock, self.counts = _Lock(self.queue), Counts()
        wide = dtype == np.float32 and has_wide_vectors(device)
        self.lanes = (WIDE_LANES if wide else LANES) if family == "cpu" else 1
        self.cores = device.max_compute_units
        kind: Defines = {"DOUBLE": "", "REAL": "double"} if dtype == np.float64 else {"REAL": "float"}
        of_family: Defines = {"CPU": ""} if family == "cpu" else {"GROUP": GROUP}
        self._basics = define_lines({**kind, **of_family, "V": self.lanes, **code_defines()})
        self._most_parts = 4 * (self.cores if family == "cpu" else GROUP)  # of a sum over a plane
        self.partial = self.buffer(2 * 8 * self._most_parts)
        self._tables: dict[bytes, Buffer] = {}
        self._programs: dict[tuple[str, ...], cl.Program] = {}
        self._kernels: dict[tuple[str, ...], cl.Kernel] = {}
        self._launched: set[cl.Kernel] = set()
        _CONTEXTS.append(self)

    def __getattr__(self, name: str) -> Any:
        """Raise the error about a fork where `_leave_behind` has emptied this context."""
        check_not_forked(-1)
        raise AttributeError(name)

    def buffer(self, size: int) -> Buffer:
        """Return a buffer of at least ``size`` bytes with any contents; released memory is used again."""
        if size >= IN_PLACE and self._pool.managed_bytes - self._pool.active_bytes > SPARE * size:
            self._pool.free_held()
        self.counts.buffers += 1
        with self._enough_memory(size):
            return cast(Buffer, self._pool.allocate(size))  # it is used as one

    @contextmanager
    def _enough_memory(self, size: int) -> Iterator[None]:
        """Raise an InputError where the block finds no memory for ``size`` bytes on the device."""
        try:
            yield
        except (cl.MemoryError, cl.LogicError) as error:
            if isinstance(error, cl.LogicError) and error.code != cl.status_code.INVALID_BUFFER_SIZE:
                raise
            used, most = in_words(self._pool.active_bytes), in_words(self.device.max_mem_alloc_size)
            raise InputError(
                f"{self.device.name.strip()}: {in_words(size)} wanted for a plane; the device has "
                f"{in_words(self.device.global_mem_size)}, at most {most} for each, and {used} are in use; a smaller "
                "grid or batch, float32, or an engine with a store wanted"
            ) from error

    def plane(self, cells: int) -> Buffer:
        """Return a buffer for ``cells`` numbers."""
        return self.buffer(cells * self.dtype.itemsize)

    def works_in_place(self, size: int) -> bool:
        """Return whether the device works in this machine's own memory, for ``size`` bytes or more."""
        is_cpu = self.device.type & cl.device_type.CPU and self.device.host_unified_memory
        return bool(size >= IN_PLACE and is_cpu)

    def table(self, numbers: np.ndarray[Any, Any]) -> Buffer:
        """Return a few read-only numbers on the device; equal numbers are transferred once."""
        key = numbers.tobytes()
        if key not in self._tables:
            self._tables[key] = self.load(numbers, cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR)
        return self._tables[key]

    def load(self, host: np.ndarray[Any, Any], flags: int) -> Buffer:
        """Return a buffer of the numbers of an array."""
        self.counts.buffers += 1
        self.counts.to_device += 0 if flags & cl.mem_flags.USE_HOST_PTR else host.nbytes
        with self._enough_memory(host.nbytes):
            return cl.Buffer(self.context, flags, hostbuf=host)

    def read(self, buffer: Buffer, host: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        """Wait for the device and copy the first numbers of a buffer to an array; return the array."""
        self.counts.waits += 1
        self.counts.from_device += host.nbytes
        cl.enqueue_copy(self.queue, host, buffer)
        return host

    def clear(self, buffer: Buffer, size: int) -> None:
        """Fill the first ``size`` bytes of a buffer, a multiple of 8, with 0."""
        self.counts.launches += 1
        cl.enqueue_fill_buffer(self.queue, buffer, np.zeros(1, np.int64), 0, size)

    def wait(self) -> None:
        """Wait until all launches are done."""
        self.counts.waits += 1
        self.queue.finish()

    def kernel(self, name: str, stems: str, defines: Defines, extra: str = "") -> cl.Kernel:
        """Return a kernel of the files kernels/<stem>.cl, joined, and ``extra`` text, with these definitions."""
        lines = self._basics + define_lines(defines)
        key = (stems, lines, extra, name)
        if key not in self._kernels:
            with first_use(self.device):
                if key[:-1] not in self._programs:
                    text = lines + "".join(map(source, ["common", *stems.split()])) + extra
                    self._programs[key[:-1]] = build(self.context, self.device, text, name)
                self._kernels[key] = cl.Kernel(self._programs[key[:-1]], name)
        return self._kernels[key]

    def launch(self, kernel: cl.Kernel, work: int, *arguments: Any) -> int:
        """Launch a kernel that shares ``work`` cells or words; return how many parts its sums have.

        A part is of a work-item on a CPU, of a work-group on a GPU.
        """
        most = work // LEAST_CELLS if self.family == "cpu" else -(-work // GROUP)
        parts = max(1, min(self._most_parts, most))
        shape = ((parts,), (1,)) if self.family == "cpu" else ((parts * GROUP,), (GROUP,))
        self.enqueue(kernel, *shape, *arguments)
        return parts

    def enqueue(self, kernel: cl.Kernel, global_size: Any, local_size: Any, *arguments: Any) -> None:
        """Launch a kernel. Drivers compile at the first launch, for seconds, so Python waits where it hears signals."""
        self.counts.launches += 1
        first = kernel not in self._launched
        if first:  # with known types all arguments are set in a microsecond, else in a hundred
            kernel.set_scalar_arg_dtypes([a.dtype if isinstance(a, np.generic) else None for a in arguments])
        kernel.set_args(*arguments)
        with first_use(self.device) if first else nullcontext():
            event = cl.enqueue_nd_range_kernel(self.queue, kernel, global_size, local_size)
            if first:
                self.queue.flush()
                while event.command_execution_status > cl.command_execution_status.COMPLETE:
                    sleep(POLL)
                self._launched.add(kernel)

    def pieces(self, count: int, work: float) -> Iterator[tuple[int, int]]:
        """Yield (first, count) of the pieces of ``count`` rows or tiles with ``work`` sums in each; wait in between.

        It waits for the piece before the last, so that the device always has another one.
        """
        parts = pieces(count, work, self.cores if self.family == "cpu" else 1)
        before: cl.Event | None = None
        for first, after in parts:
            yield first, after - first
            if len(parts) > 1:
                done = cl.enqueue_marker(self.queue)
                if before is not None:
                    self.counts.waits += 1
                    before.wait()
                before = done

    def parts(self, count: int, dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
        """Read ``count`` numbers that a kernel left in ``partial``."""
        return self.read(self.partial, np.empty(count, dtype))


@cache
def _context_of(device: cl.Device) -> tuple[cl.Context, cl.CommandQueue, MemoryPool]:
    """Return one context, queue and memory pool of a device: planes may go between backends."""
    name_processor(device)
    context = cl.Context([device])
    queue = cl.CommandQueue(context)
    return context, queue, MemoryPool(ImmediateAllocator(queue))


def _leave_behind() -> None:
    """Empty all contexts in a forked child, where the drivers have no threads; their objects are never released."""
    for context in _CONTEXTS:
        held = vars(context).copy()
        vars(context).clear()
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(held))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_behind)

device_context = cache(DeviceContext)
"""The context of a device: one for all backends of the same family and dtype."""
