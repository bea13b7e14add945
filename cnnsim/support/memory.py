"""Free memory of the machine, and the check that a computation fits into it."""

import os
from pathlib import Path

from cnnsim.support.errors import InputError

VARIABLE = "CNNSIM_MEMORY"
"""Environment variable that sets the free memory in bytes (or 8G, 500M) instead of the measured one."""

LARGE = 1 << 22
"""Cells from which on the free memory is checked: a smaller run takes less than a few hundred megabytes."""

_UNITS = {"": 1, "K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}


def free_memory() -> float:
    """Return the bytes that can be used without swapping; infinity if the system does not report them.

    That is the minimum of the kernel's MemAvailable and of what the control groups of a container still allow.

    Raises:
        InputError: the environment variable holds no size.
    """
    given = os.environ.get(VARIABLE)
    if given:
        return _parsed(given)
    free = [_kernel(), *(_group(Path(folder)) for folder in ("/sys/fs/cgroup", "/sys/fs/cgroup/memory"))]
    return min(free)


def check_memory(what: str, needed: float, cure: str) -> None:
    """Check that ``needed`` bytes are free.

    Raises:
        InputError: with the bytes needed, the bytes free, and what to do (``cure``).
    """
    free = free_memory()
    if needed > free:
        raise InputError(
            f"{what} needs {in_words(needed)} of memory, {in_words(free)} are free; {cure} ({VARIABLE}=8G would set "
            f"the limit by hand)"
        )


def in_words(size: float) -> str:
    """Return a number of bytes with a unit: 80 GB, 1.5 MB."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if size < 1000 or unit == "TB":
            break
        size /= 1000
    return f"{size:.3g} {unit}"


def _parsed(text: str) -> float:
    unit = text[-1].upper() if text[-1].isalpha() else ""
    try:
        size = float(text[: len(text) - len(unit)]) * _UNITS[unit]
    except (ValueError, KeyError) as error:
        raise InputError(f"{VARIABLE}={text}; bytes wanted, such as 8G") from error
    if not size > 0:
        raise InputError(f"{VARIABLE}={text}; a size above 0 wanted, such as 8G")
    return size


def _kernel() -> float:
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration):  # another system: all that is built in
        names = getattr(os, "sysconf_names", {})
        if "SC_PHYS_PAGES" not in names:
            return float("inf")
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")


def _group(folder: Path) -> float:
    """Return the bytes that a control group (version 2 or 1) still allows; its file cache counts as free."""
    for limit, usage in (("memory.max", "memory.current"), ("memory.limit_in_bytes", "memory.usage_in_bytes")):
        try:
            most, used = (folder / limit).read_text().strip(), int((folder / usage).read_text())
            kept = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
        except (OSError, ValueError):
            continue
        if most != "max":
            return float(int(most) - used + int(kept.get("inactive_file", 0)))
    return float("inf")
