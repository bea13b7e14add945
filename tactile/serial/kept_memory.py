"""Asking the C library to keep memory that was given back, so that no frame waits for the kernel to hand out pages.

By default the GNU library returns every block over 128 KiB, and fetches it anew for the next array of that size: of the
arrays of a tare that takes most of their time. Elsewhere nothing happens.

Source: ``mallopt(3)``.
"""

import ctypes
import sys
from contextlib import suppress

MMAP_THRESHOLD, TRIM_THRESHOLD = -3, -1
"""Parameters of ``mallopt``: from how many bytes a block has pages of its own; how many may lie idle."""
LARGEST, IDLE = 32 * 2**20, 64 * 2**20
"""[bytes] The most that the library takes for the first, and far more than a run gives back at once."""


def keep_memory() -> bool:
    """Ask for this process; return whether the library agreed."""
    if not sys.platform.startswith("linux"):
        return False
    with suppress(OSError, AttributeError):  # another C library
        mallopt = ctypes.CDLL(None).mallopt
        return bool(mallopt(MMAP_THRESHOLD, LARGEST)) and bool(mallopt(TRIM_THRESHOLD, IDLE))
    return False
