"""PoCL 3.0 on processors unknown to its LLVM: a processor name that LLVM knows, and the vector width."""

import ctypes
import os
import platform
from pathlib import Path

import pyopencl as cl

from cnnsim.support import InputError

VARIABLE = "CNNSIM_POCL_PROCESSOR"
AUTO = "auto"
_UNKNOWN = b"generic"
_NAMES = ((b"skx", "avx512vl"), (b"haswell", "avx2"), (b"x86-64", "sse2"))
"""LLVM's processor names, the most able first, each with the flag of /proc/cpuinfo that it needs."""
_NARROW = "-znver1", "-znver2", "-znver3"
"""Ends of the versions of PoCL devices that LLVM compiles for without AVX-512."""
_FIELDS = 4096  # bytes of a device's record that are searched


def name_processor(device: cl.Device) -> None:
    """Replace the processor name "generic" in the record of a PoCL device by that of CNNSIM_POCL_PROCESSOR.

    PoCL 3.0 (the newest on PyPI) asks its LLVM 14 for the processor's name. For a younger processor the answer is
    "generic", which LLVM then refuses for x86 ("unknown target CPU 'generic'"), and no option of PoCL sets the name.
    The string in the device's record is overwritten. It is another library's memory, so this is done only if the
    variable is set, to a name that LLVM knows or to "auto". Other devices are not changed.

    Raises:
        InputError: a name that is longer than the old one.
    """
    name = os.environ.get(VARIABLE, "").strip().encode()
    if not (name and _is_unnamed(device)):
        return
    if name == AUTO.encode():
        name = next(known for known, flag in _NAMES if flag in _processor_flags())
    if len(name) > len(_UNKNOWN):
        raise InputError(
            f"{VARIABLE} is {name.decode()!r}; {AUTO!r} or a name of at most {len(_UNKNOWN)} letters wanted"
        )
    writable = _writable_memory()
    for field in range(device.int_ptr, device.int_ptr + _FIELDS, 8):
        if not _within(writable, field, 8):
            return
        string = ctypes.c_uint64.from_address(field).value
        size = len(_UNKNOWN) + 1
        if _within(writable, string, size) and ctypes.string_at(string, size) == _UNKNOWN + b"\0":
            ctypes.memmove(string, name + b"\0", len(name) + 1)
            return


def remark(device: cl.Device) -> str:
    """Return a remedy for a device on which no program builds; empty if none is known."""
    if os.environ.get(VARIABLE, "").strip() or not _is_unnamed(device):
        return ""
    return (
        f"PoCL calls this processor 'generic', which its compiler may refuse; set the environment variable "
        f"{VARIABLE}={AUTO}, which names it as an older one in PoCL's memory"
    )


def has_wide_vectors(device: cl.Device) -> bool:
    """Return whether a device is this machine's processor and uses AVX-512, registers of 16 float32."""
    is_cpu = device.type & cl.device_type.CPU != 0
    return is_cpu and not device.version.endswith(_NARROW) and "avx512vl" in _processor_flags()


def _is_unnamed(device: cl.Device) -> bool:
    unknown = device.platform.name == "Portable Computing Language" and device.version.endswith("-generic")
    return unknown and platform.machine() in ("x86_64", "AMD64") and Path("/proc/self/maps").exists()


def _processor_flags() -> set[str]:
    if not Path("/proc/cpuinfo").exists():
        return set()
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((set(line.split(":", 1)[1].split()) for line in lines if line.startswith("flags")), set())


def _writable_memory() -> list[tuple[int, int]]:
    """Return the (first, last + 1) addresses of this process that may be read and written."""
    found = []
    for line in Path("/proc/self/maps").read_text().splitlines():
        span, rights = line.split()[:2]
        if rights.startswith("rw"):
            first, end = span.split("-")
            found.append((int(first, 16), int(end, 16)))
    return found


def _within(areas: list[tuple[int, int]], address: int, size: int) -> bool:
    return any(first <= address and address + size <= end for first, end in areas)
