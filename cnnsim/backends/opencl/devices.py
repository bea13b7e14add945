"""devices: the OpenCL devices of this machine, as plain values."""

from dataclasses import dataclass


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
        from cnnsim.backends.opencl import device as opencl
        from cnnsim.backends.opencl import pocl
    except ModuleNotFoundError as error:
        if error.name != "pyopencl":
            raise
        return []
    found = opencl.devices()
    chosen = opencl.choose_device() if found else None
    return [
        OpenCLDevice(
            index,
            device.name.strip(),
            device.platform.name.strip(),
            device.version.strip(),
            opencl.type_of(device),
            device.max_compute_units,
            device.global_mem_size,
            opencl.has_float64(device),
            opencl.family_of(device),
            device == chosen,
            pocl.remark(device),
        )
        for index, device in enumerate(found)
    ]
