"""Memory pages of buffers that lie in this machine's own memory: large ones are asked for, as NumPy asks for arrays."""

import ctypes
import mmap
from functools import cache
from typing import Any

import numpy as np
import pyopencl as cl

LEAST = 1 << 22
"""Bytes from which on NumPy asks for them."""


def works_in_memory(device: cl.Device) -> bool:
    """Return whether a device is the processor, whose buffers lie in this machine's own memory."""
    return bool(device.type & cl.device_type.CPU and device.host_unified_memory)


def ask_for_large_pages(queue: cl.CommandQueue, buffer: cl.Buffer) -> None:
    """Tell Linux that a new buffer of a processor's device may lie in pages of 2 MiB.

    A page is brought in when it is first written to, which of 4 KiB costs a third of a transient of 50 steps.
    ``queue`` should be one that no kernel waits in. Nothing is done for GPUs, small buffers or on other systems.
    """
    device, advise = queue.device, _advise()
    if buffer.size < LEAST or advise is None or not works_in_memory(device):
        return
    flags = cl.map_flags.WRITE_INVALIDATE_REGION  # nothing is copied
    memory, _ = cl.enqueue_map_buffer(queue, buffer, flags, 0, (buffer.size,), np.dtype(np.uint8))
    first = -(-memory.ctypes.data // mmap.PAGESIZE) * mmap.PAGESIZE
    advise(first, memory.ctypes.data + buffer.size - first, mmap.MADV_HUGEPAGE)  # only advice: it may fail
    memory.base.release(queue)


@cache
def _advise() -> Any:
    """Return the system's madvise, None where there is none that knows of large pages."""
    advise = getattr(ctypes.CDLL(None), "madvise", None) if hasattr(mmap, "MADV_HUGEPAGE") else None
    if advise is not None:
        advise.argtypes, advise.restype = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int), ctypes.c_int
    return advise
