"""An OpenCL device for each process that computes beside others: one that no other has, in turn if there are more."""

import os
import platform
import tempfile
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

from cnnsim.backends.opencl.device.devices import VARIABLE, all_devices, choose_device, title, type_of
from cnnsim.support.cache_folder import first_usable, user_cache
from cnnsim.support.exclusive_file import lock


@cache
def own_device() -> int | None:
    """Return the number of a device for this process, the same as long as it lives; None if the environment names one.

    Those that it is chosen from are of the kind of the device that is taken unasked, and of its platform. Each is
    claimed by a locked file, which the system lets go when the process ends, however it ends; so a worker that is
    started in place of a dead one gets that one's device. On a cluster each machine counts its own.
    """
    if os.environ.get(VARIABLE, "").strip():
        return None
    usual, found = choose_device(), all_devices()
    alike = [
        index
        for index, device in enumerate(found)
        if device.platform == usual.platform and type_of(device) == type_of(usual)
    ]
    return alike[0] if len(alike) == 1 else _claimed(alike)


def title_of(backend: Any) -> str:
    """Return what the device of an OpenCL backend is called, with its number."""
    return f"{all_devices().index(backend.device)}: {title(backend.device)}"


def _claimed(devices: list[int]) -> int:
    shared = Path(tempfile.gettempdir()) / f"cnnsim-devices-{os.getuid() if hasattr(os, 'getuid') else 0}"
    folder = first_usable([user_cache() / "cellular-wave-touch" / "devices", shared], "claims on devices")
    for turn in count():
        for index in devices:
            name = f"{platform.node()}-{index}-{turn}"  # a home may be shared by machines
            file = os.open(folder / name, os.O_RDWR | os.O_CREAT, 0o600)
            if lock(file):
                return index  # the file stays open, and locked, until this process ends
            os.close(file)
    raise AssertionError("counting has no end")
