"""The OpenCL devices of this machine: their list, the choice of one, and one for each worker process."""

import os
import platform
import tempfile
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cnnsim.support import InputError
from cnnsim.support.cache_folder import first_usable, user_cache
from cnnsim.support.exclusive_file import lock

if TYPE_CHECKING:
    import pyopencl as cl  # the functions import it themselves: this module is there without it

Family = Literal["cpu", "gpu"]
"""Two families of kernels: one work-item a core with long vectors, or many work-items that share local memory."""

VARIABLE = "CNNSIM_DEVICE"
CURE = 'pip install "pyopencl[pocl]" brings one that computes on the processor'


@dataclass(frozen=True)
class OpenCLDevice:
    """One OpenCL device; its ``index`` or a part of its ``name`` chooses it, ``chosen`` marks the default.

    ``remark`` says what has to be set before the device can compute, or is empty.
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
    """Return pyopencl's devices, platform by platform; the index in this list is a device's number.

    Raises:
        InputError: this process was forked from one that had asked before.
    """
    import pyopencl as cl

    from cnnsim.backends.opencl.device.kernel_cache import prepare_cache  # imports pyopencl

    check_not_forked(_first_asked_by())
    prepare_cache()
    try:
        platforms = cl.get_platforms()
    except cl.Error:  # the loader's way to say that there are none
        platforms = []
    found = []
    for each in platforms:
        try:
            found += each.get_devices()
        except cl.Error:  # a platform without a device, such as a driver without its card
            continue
    return found


@cache
def _first_asked_by() -> int:
    return os.getpid()


def check_not_forked(owner: int) -> None:
    """Refuse OpenCL in a forked child of the process that has used it: the drivers' threads are not in the child.

    Raises:
        InputError: this is not the process ``owner``.
    """
    if os.getpid() != owner:
        raise InputError(
            "OpenCL was used before this process was forked, and a forked process has none of its threads; a spawned "
            "process wanted: multiprocessing.get_context('spawn')"
        )


def choose_device(which: int | str | None = None) -> "cl.Device":
    """Return the device with this number or this part of its name or its platform's.

    None: the one that the environment variable CNNSIM_DEVICE names; without it the first GPU, else the first device.

    Raises:
        InputError: there is no device, or not this one; the message has the cure, or the devices to choose from.
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


@cache
def own_device() -> int | None:
    """Return the number of a device for this worker process; None if the environment variable names one.

    The devices of the default device's kind and platform are dealt out in turn. Each is claimed by a locked file,
    which the system unlocks when the process ends, so a worker that replaces a dead one gets its device.
    """
    if os.environ.get(VARIABLE, "").strip():
        return None
    usual, found = choose_device(), all_devices()
    alike = [
        index
        for index, device in enumerate(found)
        if device.platform == usual.platform and type_of(device) == type_of(usual)
    ]
    return alike[0] if len(alike) == 1 else _claim(alike)


def title_of(backend: Any) -> str:
    """Return the number and name of the device of an OpenCL backend."""
    return f"{all_devices().index(backend.device)}: {title(backend.device)}"


def _claim(devices: list[int]) -> int:
    shared = Path(tempfile.gettempdir()) / f"cnnsim-devices-{os.getuid() if hasattr(os, 'getuid') else 0}"
    folder = first_usable([user_cache() / "cellular-wave-touch" / "devices", shared], "claims on devices")
    for turn in count():
        for index in devices:
            name = f"{platform.node()}-{index}-{turn}"  # machines may share a home folder
            file = os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o600)
            if lock(file):
                return index  # the file stays open, and locked, until this process ends
            os.close(file)
    raise AssertionError("counting has no end")
