"""Counts of launches, waits, buffers and bytes: the cost of work on a device in units that need no clock."""

from dataclasses import dataclass


@dataclass
class Counts:
    """The cost of some work in units that do not depend on the device.

    ``launches`` of kernels and fills, ``waits`` of the host, ``buffers`` taken, and bytes moved ``to_device`` and
    ``from_device``.
    """

    launches: int = 0
    waits: int = 0
    buffers: int = 0
    to_device: int = 0
    from_device: int = 0
