"""The OpenCL devices of this machine: which there are, and which one computes."""

import os
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Literal

from cnnsim.support import InputError

if TYPE_CHECKING:
    import pyopencl as cl  # the functions import it themselves: this module is there without it

Family = Literal["cpu", "gpu"]
"""Two families of kernels: a few work-items with long vectors, or many work-items that share local memory."""

VARIABLE = "CNNSIM_DEVICE"
CURE = 'pip install "pyopencl[pocl]" brings one that computes on the processor'


@dataclass(frozen=True)
class OpenCLDevice:
    """One OpenCL device; its ``index`` or a part of its ``name`` chooses it, ``chosen`` is the one taken unasked.

    ``remark`` says what has to be set before it computes, if anything.
    """

    index: int
    name: str
    platform: str
    version: str
    type: str
    compute_units: int
    memory_bytes: int
    float64: bool
    family: str
    chosen: bool
    remark: str


def devices() -> list[OpenCLDevice]:
    """Return the OpenCL devices, none where pyopencl or a driver is missing (``backends.get("opencl")`` says which).

    Raises:
        InputError: the environment variable CNNSIM_DEVICE names none of them.
    """
    try:
        from cnnsim.backends.opencl.device.pocl import remark
    except ModuleNotFoundError as error:
        if error.name != "pyopencl":
            raise
        return []
    found = all_devices()
    chosen = choose_device() if found else None
    return [
        OpenCLDevice(
            index,
            device.name.strip(),
            device.platform.name.strip(),
            device.version.strip(),
            type_of(device),
            device.max_compute_units,
            device.global_mem_size,
            has_float64(device),
            family_of(device),
            device == chosen,
            remark(device),
        )
        for index, device in enumerate(found)
    ]


def all_devices() -> list["cl.Device"]:
    """Return what pyopencl has of all devices, platform by platform; the index in this list is a device's number.

    Raises:
        InputError: this process was forked from one that had asked before.
    """
    import pyopencl as cl

    from cnnsim.backends.opencl.device.pocl_cache import prepare

    check_not_forked(_first_asked_by())
    prepare()
    try:
        platforms = cl.get_platforms()
    except cl.Error:  # the loader's way to say that there are none
        platforms = []
    found = []
    for platform in platforms:
        try:
            found += platform.get_devices()
        except cl.Error:  # a platform without a device, such as a driver without its card
            continue
    return found


@cache
def _first_asked_by() -> int:
    return os.getpid()


def check_not_forked(owner: int) -> None:
    """Refuse OpenCL in a child of the process that has used it: the threads of its drivers are not in the child.

    Raises:
        InputError: this is not the process ``owner``.
    """
    if os.getpid() != owner:
        raise InputError(
            "OpenCL was used before this process was forked, and its threads stayed behind; a process that starts anew "
            "wanted: multiprocessing.get_context('spawn')"
        )


def choose_device(which: int | str | None = None) -> "cl.Device":
    """Return the device with this number or this part of its name or its platform's.

    None: what the environment variable CNNSIM_DEVICE says; if it is silent, the first GPU, else the first device.

    Raises:
        InputError: there is no device at all, or not this one; the message has the cure, or the choice.
    """
    found = all_devices()
    if not found:
        raise InputError(f"there is no OpenCL device; {CURE}")
    asked = which if which is not None else os.environ.get(VARIABLE, "").strip()
    if asked == "":
        return next((device for device in found if type_of(device) == "gpu"), found[0])
    source = "" if which is not None else f" ({VARIABLE})"
    choice = "; ".join(f"{i}: {title(device)}" for i, device in enumerate(found))
    if isinstance(asked, int) or asked.isdecimal():
        if not 0 <= int(asked) < len(found):
            raise InputError(f"there is no OpenCL device {asked}{source}; known are {choice}")
        return found[int(asked)]
    for device in found:
        if asked.casefold() in title(device).casefold():
            return device
    raise InputError(f"no OpenCL device is called {asked!r}{source}; known are {choice}")


def title(device: "cl.Device") -> str:
    """Return a device's name and platform."""
    return f"{device.name.strip()} ({device.platform.name.strip()})"


def type_of(device: "cl.Device") -> str:
    """Return "cpu", "gpu" or "accelerator"."""
    import pyopencl as cl

    names = {cl.device_type.CPU: "cpu", cl.device_type.GPU: "gpu"}
    return next((name for bit, name in names.items() if device.type & bit), "accelerator")


def family_of(device: "cl.Device") -> Family:
    """Return the family of kernels for a device: by its type."""
    return "cpu" if type_of(device) == "cpu" else "gpu"


def has_float64(device: "cl.Device") -> bool:
    """Return whether a device computes in float64."""
    return bool(device.double_fp_config)
