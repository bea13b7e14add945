"""The command ``cnnsim devices``: which OpenCL devices there are, and which one would compute."""

from typing import Any

import click

from cnnsim.backends import OPENCL_CURE
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.errors import InputError


@click.command(epilog=examples("cnnsim devices", "cnnsim devices --json", "CNNSIM_DEVICE=1 cnnsim devices"))
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def devices(as_json: bool) -> None:
    """List the OpenCL devices; the opencl backend takes the one marked *.

    The environment variable CNNSIM_DEVICE, a number or part of a name, chooses another one.
    """
    found = describe_devices()
    if as_json:
        print_json(found)
        return
    for device in found:
        double = "float32, float64" if device["float64"] else "float32"
        mark = "*" if device["chosen"] else " "
        click.echo(f"{mark} {device['index']}  {device['name']}  ({device['platform']})")
        click.echo(f"     {device['type']}, {device['compute_units']} compute units, {double}")


def describe_devices() -> list[dict[str, Any]]:
    """Return what there is to know of each OpenCL device, as plain values.

    Raises:
        InputError: pyopencl is not installed, there is no device, or CNNSIM_DEVICE names none.
    """
    try:
        from cnnsim.backends.opencl import device as opencl
    except ModuleNotFoundError as error:
        if error.name != "pyopencl":
            raise
        raise InputError(f"listing devices needs pyopencl: {OPENCL_CURE}") from error
    chosen = opencl.choose_device()
    return [
        {
            "index": index,
            "name": device.name.strip(),
            "platform": device.platform.name.strip(),
            "version": device.version.strip(),
            "type": opencl.type_of(device),
            "compute_units": device.max_compute_units,
            "memory_bytes": device.global_mem_size,
            "float64": opencl.has_float64(device),
            "family": opencl.family_of(device),
            "chosen": device == chosen,
        }
        for index, device in enumerate(opencl.devices())
    ]
