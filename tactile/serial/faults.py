"""Faults on request: what cables, hubs and firmware do to a stream of packets."""

from dataclasses import dataclass, fields

import numpy as np

from cnnsim.support import InputError


@dataclass(frozen=True)
class Faults:
    """Rates of faults, all 0 by default.

    ``drop``, ``repeat``: probability per frame; ``flip``: per bit; ``split``: send every frame in pieces with pauses;
    ``stall``, ``unplug``: period [s] of these faults, which last ``stall_for`` and ``unplug_for`` [s]. Frames of a
    stall are sent together afterwards; frames of an unplugged time are lost.

    Raises:
        InputError: a probability outside 0..1 or a negative time.
    """

    drop: float = 0.0
    repeat: float = 0.0
    flip: float = 0.0
    split: bool = False
    stall: float = 0.0
    stall_for: float = 0.2
    unplug: float = 0.0
    unplug_for: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = float(getattr(self, field.name))
            most = 1.0 if field.name in ("drop", "repeat", "flip") else float("inf")
            if not 0 <= value <= most:
                raise InputError(f"fault {field.name} = {value}, a number from 0 to {most:g} wanted")

    def spoil(self, packet: bytes, rng: np.random.Generator) -> list[bytes]:
        """Return the pieces that are sent instead of a packet."""
        if self.drop and rng.random() < self.drop:
            return []
        if self.flip:
            bits = np.unpackbits(np.frombuffer(packet, np.uint8))
            packet = np.packbits(bits ^ (rng.random(bits.size) < self.flip)).tobytes()
        copies = 2 if self.repeat and rng.random() < self.repeat else 1
        if not self.split:
            return [packet] * copies
        cuts = sorted(rng.integers(0, len(packet) + 1, 2).tolist())
        return [packet[a:b] for a, b in zip([0, *cuts], [*cuts, len(packet)], strict=True)] * copies

    def in_spell(self, t: float, period: float, lasting: float) -> bool:
        """Return whether at time ``t`` [s] the fault is on: for ``lasting`` after each ``period``."""
        return bool(period) and t >= period and t % (period + lasting) >= period
