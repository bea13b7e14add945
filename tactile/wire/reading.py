"""Readings of a decoder, and the counters of a stream."""

from dataclasses import asdict, dataclass

from cnnsim.support import Floats

Taxels = Floats
"""(taxels, 3): readings in the device's order and unit, last axis (x, y, z) of the device; (taxels, 1): z alone."""


@dataclass
class Counts:
    """Counters of a stream.

    ``good`` frames; ``bad_checksum`` frames that began but had no valid end; ``resynchronised`` bytes outside frames;
    ``missing`` frames by sequence number; ``missing_by_rate`` an estimate for frames without a number; ``repeated``
    frames, which are dropped; ``unfit`` complete frames of another shape than described; ``late`` frames more than
    `clock.LATE` behind the line of the device clock; ``overflowed`` bytes dropped by a full queue.
    """

    good: int = 0
    bad_checksum: int = 0
    resynchronised: int = 0
    missing: int = 0
    missing_by_rate: int = 0
    repeated: int = 0
    unfit: int = 0
    late: int = 0
    overflowed: int = 0

    def plain(self) -> dict[str, int]:
        """Return the counters by name."""
        return asdict(self)

    def __str__(self) -> str:
        return ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in self.plain().items())


@dataclass(frozen=True)
class Reading:
    """One decoded frame.

    ``values`` (taxels, 3); ``device`` number of the board on this wire, None if one frame has all of them in order;
    ``sequence`` number of the device, None without one; ``t_device`` [s], NaN without a device clock; ``end`` position
    in the stream after this frame; ``checked`` whether a CRC protects the frame, so that its sequence number can be
    trusted.
    """

    values: Taxels
    end: int
    device: int | None = None
    sequence: int | None = None
    t_device: float = float("nan")
    checked: bool = True
