"""The command ``cnnsim devices``: the list of OpenCL devices, and the one chosen by default."""

from dataclasses import asdict

import click

from cnnsim import backends
from cnnsim.backends.opencl.device.devices import devices as list_devices
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.memory import in_words
from cnnsim.support.terminal import echo, hanging


@click.command(epilog=examples("cnnsim devices", "cnnsim devices --json", "CNNSIM_DEVICE=1 cnnsim devices"))
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def devices(as_json: bool) -> None:
    """List the OpenCL devices.

    The opencl backend takes the one marked *.

    The environment variable CNNSIM_DEVICE, a number or part of a name, chooses another one. PoCL 3.0 does not know
    processors newer than itself; CNNSIM_POCL_PROCESSOR=auto names such a one as an older one, in PoCL's memory.
    """
    found = list_devices()
    if not found:
        backends.get("opencl")  # raises, with what is missing
    if as_json:
        print_json([asdict(device) for device in found])
        return
    for device in found:
        double = "float32, float64" if device.float64 else "float32"
        mark = "*" if device.chosen else " "
        echo(hanging(f"{mark} {device.index}  ", f"{device.name}  ({device.platform})", 5))
        memory = in_words(device.memory_bytes)
        echo(hanging("", f"{device.type}, {device.compute_units} compute units, {memory}, {double}", 5))
        if device.remark:
            echo(hanging("", device.remark, 5))
