"""Which OpenCL devices there are, and which one computes."""

import os
from typing import Literal

import pyopencl as cl

from cnnsim.support import InputError

Family = Literal["cpu", "gpu"]
"""Two families of kernels: a few work-items with long vectors, or many work-items that share local memory."""

VARIABLE = "CNNSIM_DEVICE"
CURE = 'pip install "pyopencl[pocl]" brings one that computes on the processor'


def devices() -> list[cl.Device]:
    """Return all OpenCL devices, platform by platform; the index in this list is a device's number."""
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


def choose_device(which: int | str | None = None) -> cl.Device:
    """Return the device with this number or this part of its name or its platform's.

    None: what the environment variable CNNSIM_DEVICE says; if it is silent, the first GPU, else the first device.

    Raises:
        InputError: there is no device at all, or not this one; the message has the cure, or the choice.
    """
    found = devices()
    if not found:
        raise InputError(f"there is no OpenCL device; {CURE}")
    asked = which if which is not None else os.environ.get(VARIABLE, "").strip()
    if asked == "":
        return next((d for d in found if d.type & cl.device_type.GPU), found[0])
    return _matching(found, asked, "" if which is not None else f" ({VARIABLE})")


def _matching(found: list[cl.Device], asked: int | str, source: str) -> cl.Device:
    choice = "; ".join(f"{i}: {title(device)}" for i, device in enumerate(found))
    if isinstance(asked, int) or asked.isdecimal():
        if not 0 <= int(asked) < len(found):
            raise InputError(f"there is no OpenCL device {asked}{source}; there are {choice}")
        return found[int(asked)]
    for device in found:
        if asked.casefold() in title(device).casefold():
            return device
    raise InputError(f"no OpenCL device is called {asked!r}{source}; there are {choice}")


def title(device: cl.Device) -> str:
    """Return a device's name and platform."""
    return f"{device.name.strip()} ({device.platform.name.strip()})"


def family_of(device: cl.Device) -> Family:
    """Return the family of kernels for a device: by its type."""
    return "cpu" if device.type & cl.device_type.CPU else "gpu"


def type_of(device: cl.Device) -> str:
    """Return "cpu", "gpu" or "accelerator"."""
    names = {cl.device_type.CPU: "cpu", cl.device_type.GPU: "gpu"}
    return next((name for bit, name in names.items() if device.type & bit), "accelerator")


def has_float64(device: cl.Device) -> bool:
    """Return whether a device computes in float64."""
    return bool(device.double_fp_config)
