"""PoCL's cache of kernels on the disk: it is emptied after a process that ended at the first use of a kernel.

PoCL aborts the process on a damaged file, so the first use of each kernel is marked by a locked file in the cache. A
mark that nobody locks is of a process that has ended there.
"""

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from itertools import count
from pathlib import Path

import pyopencl as cl

from cnnsim.support import InputError
from cnnsim.support.cache_folder import first_usable, user_cache
from cnnsim.support.exclusive_file import lock

VARIABLE = "POCL_CACHE_DIR"
_MARK = "cnnsim-first-use-"
_ENTRIES = re.compile("[A-P]{2}")
"""Names of PoCL's own folders in its cache: no other file there is deleted."""
_NUMBERS = count()
_DAMAGED = (
    cl.status_code.INVALID_BINARY,
    cl.status_code.INVALID_PROGRAM_EXECUTABLE,
    cl.status_code.INVALID_KERNEL_NAME,
    cl.status_code.INVALID_KERNEL_DEFINITION,
)
"""What a driver says of a damaged file that does not abort it."""


@cache
def prepare_cache() -> None:
    """Name a folder for PoCL that only this user can write, unless POCL_CACHE_DIR does, and empty it if it is damaged.

    PoCL reads the variable when it is loaded.
    """
    if VARIABLE not in os.environ:
        os.environ[VARIABLE] = str(first_usable([user_cache() / "cellular-wave-touch" / "pocl"], "OpenCL kernels"))
    folder = Path(os.environ[VARIABLE])
    with suppress(OSError):
        left = [mark for mark in folder.glob(f"{_MARK}*") if _is_left(mark)]
        for entry in folder.iterdir() if left else ():
            if _ENTRIES.fullmatch(entry.name):
                shutil.rmtree(entry, ignore_errors=True)
        for mark in left:
            mark.unlink(missing_ok=True)


@contextmanager
def first_use(device: cl.Device) -> Iterator[None]:
    """Mark the cache in a block that builds, makes or launches a kernel for the first time.

    Raises:
        InputError: the driver refuses a kernel that it has built; the next process empties the cache.
    """
    mark, file = Path(os.environ.get(VARIABLE, ""), f"{_MARK}{os.getpid()}-{next(_NUMBERS)}"), None
    with suppress(OSError):  # the folder of another driver, or none
        file = os.open(mark, os.O_WRONLY | os.O_CREAT, 0o600)
        lock(file)
    try:
        yield
    except cl.LogicError as error:
        if error.code not in _DAMAGED:
            mark.unlink(missing_ok=True)
            raise
        raise InputError(
            f"{device.name}: a kernel of the cache {mark.parent} is damaged ({error}); the next run compiles it again"
        ) from error
    except BaseException:
        mark.unlink(missing_ok=True)
        raise
    else:
        mark.unlink(missing_ok=True)
    finally:
        if file is not None:
            os.close(file)


def _is_left(mark: Path) -> bool:
    """Return whether the process that made a mark has ended."""
    file = os.open(mark, os.O_WRONLY)
    try:
        return lock(file)
    finally:
        os.close(file)
