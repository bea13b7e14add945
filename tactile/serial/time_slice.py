"""Asking the kernel for a short time slice, so that a thread that sleeps a lot runs soon after it is woken.

Linux 6.12 and later let any program choose its slice (EEVDF); a task with a short one may take the processor from one
with a long one at once, for no larger share of it. Elsewhere nothing happens.

Source: ``sched_setattr(2)``; the slice of SCHED_OTHER goes into ``sched_runtime``.
"""

import ctypes
import os
import platform
import struct
import sys

SLICE = 100_000
"""[ns] The shortest that the kernel takes."""
CALLS = {"x86_64": 314, "aarch64": 274}
"""Number of the system call ``sched_setattr``, which the C library has no function for."""
ATTRIBUTES = struct.Struct("<IIQiIQQQ")
"""size, policy, flags, nice, priority, runtime, deadline, period."""


def ask_for_short_slices() -> bool:
    """Ask for this thread and those that it will start; return whether the kernel agreed."""
    number = CALLS.get(platform.machine())
    if not sys.platform.startswith("linux") or number is None:
        return False
    attributes = ATTRIBUTES.pack(ATTRIBUTES.size, 0, 0, os.nice(0), 0, SLICE, 0, 0)
    return ctypes.CDLL(None, use_errno=True).syscall(number, 0, attributes, 0) == 0
