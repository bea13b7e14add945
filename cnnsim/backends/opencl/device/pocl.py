"""PoCL 3.0 on processors newer than itself: give its compiler, if asked to, a processor name that it knows."""

import ctypes
import os
import platform
from pathlib import Path

import pyopencl as cl

from cnnsim.support import InputError

VARIABLE = "CNNSIM_POCL_PROCESSOR"
AUTO = "auto"
_UNKNOWN = b"generic"
_HASWELL = frozenset(
    ("avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "rdrand", "fsgsbase", "invpcid", "xsaveopt")
)
_SKYLAKE_SERVER = _HASWELL | {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl", "adx", "clflushopt"}
_NAMES = ((b"skx", _SKYLAKE_SERVER), (b"haswell", _HASWELL), (b"x86-64", frozenset[str]()))
"""Names that fit where "generic" stood, the most able first, each with what /proc/cpuinfo has to say for it."""
_NARROW = "-znver1", "-znver2", "-znver3"
"""Ends of the versions of PoCL devices whose names LLVM knows without AVX-512."""
_FIELDS = 4096  # bytes of a device's record that are looked through


def name_processor(device: cl.Device) -> None:
    """Replace the processor name "generic" in the record of a PoCL device by the one that CNNSIM_POCL_PROCESSOR says.

    PoCL 3.0 (the newest on PyPI) asks its LLVM 14 for the processor's name. For a processor younger than LLVM 14 the
    answer is "generic", which that same LLVM then refuses for x86 ("unknown target CPU 'generic'"), so nothing can
    be built. No option of PoCL sets the name. It lies as a string of its own in the device's record, and is
    overwritten there, which is another library's memory: so only if the variable is set, to a name that LLVM knows, or
    to "auto" for that of an older processor that can do no more than this one. Nothing is done on other platforms,
    other processors, or where the string is not found.

    Raises:
        InputError: a name that is too long for the place of the old one.
    """
    name = os.environ.get(VARIABLE, "").strip().encode()
    if not (name and _may_be_named(device)):
        return
    if name == AUTO.encode():
        flags = _processor_flags()
        name = next(known for known, wanted in _NAMES if flags >= wanted)
    if len(name) > len(_UNKNOWN):
        raise InputError(
            f"{VARIABLE} is {name.decode()!r}; {AUTO!r} or a name of at most {len(_UNKNOWN)} letters wanted"
        )
    ours = _writable_memory()
    for field in range(device.int_ptr, device.int_ptr + _FIELDS, 8):
        if not _within(ours, field, 8):
            return
        string = ctypes.c_uint64.from_address(field).value
        if _within(ours, string, len(_UNKNOWN) + 1) and ctypes.string_at(string, len(_UNKNOWN) + 1) == _UNKNOWN + b"\0":
            ctypes.memmove(string, name + b"\0", len(name) + 1)
            return


def remark(device: cl.Device) -> str:
    """Return what to do about a device for which nothing can be built, or nothing where that is not known."""
    if os.environ.get(VARIABLE, "").strip() or not _may_be_named(device):
        return ""
    return (
        f"PoCL calls this processor 'generic', which its compiler may refuse; set the environment variable "
        f"{VARIABLE}={AUTO}, which names it as an older one in PoCL's memory"
    )


def _may_be_named(device: cl.Device) -> bool:
    """Return whether a device is PoCL's and was given the name that its compiler refuses."""
    unknown = device.platform.name == "Portable Computing Language" and device.version.endswith("-generic")
    return unknown and platform.machine() in ("x86_64", "AMD64") and Path("/proc/self/maps").exists()


def has_wide_vectors(device: cl.Device) -> bool:
    """Return whether a device is this machine's processor, and that has registers of 16 float32 (AVX-512).

    PoCL names a processor by the last one of its kind that its LLVM knows, whose registers are the ones in use.
    """
    named_without = device.version.endswith(_NARROW)
    return device.type & cl.device_type.CPU != 0 and not named_without and _processor_flags() >= _SKYLAKE_SERVER


def _processor_flags() -> set[str]:
    if not Path("/proc/cpuinfo").exists():
        return set()
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            return set(line.split(":", 1)[1].split())
    return set()


def _writable_memory() -> list[tuple[int, int]]:
    """Return the (first, last + 1) addresses of this process that may be read and written."""
    found = []
    for line in Path("/proc/self/maps").read_text().splitlines():
        span, rights = line.split()[:2]
        if rights.startswith("rw"):
            first, end = span.split("-")
            found.append((int(first, 16), int(end, 16)))
    return found


def _within(spans: list[tuple[int, int]], address: int, size: int) -> bool:
    return any(first <= address and address + size <= end for first, end in spans)
