"""Frames over a bad cable: every frame that a decoder gives out is held against what was sent.

The cable, per byte: with probability `BYTE` one bit is changed (half of the faults), the byte is lost (a quarter), or
one at random comes after it (a quarter); and before each packet, with probability `BURST`, 1 to 40 bytes are lost, as
where a buffer ran over.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.kits.wire import pair, stream

BYTE, BURST = 1e-4, 1e-3
ONCE = 4000
"""Packets that one decoder sees."""


@dataclass
class Judged:
    """What became of the frames of a format.

    ``sent``; ``damaged`` packets that the cable touched; ``right`` frames, as they were sent; ``false`` ones, with
    values or a number that nobody sent, or out of order; ``lost`` frames; ``said`` of them, by the decoder's count.
    """

    name: str
    sent: int = 0
    damaged: int = 0
    right: int = 0
    false: int = 0
    said: int = 0

    @property
    def lost(self) -> int:
        """Frames that were sent and not given out as they were."""
        return self.sent - self.right


def damage(packets: list[bytes], rng: np.random.Generator, byte: float = BYTE, burst: float = BURST) -> list[bytes]:
    """Return what arrives of the packets, each for itself."""
    out, left = [], 0
    for packet in packets:
        if rng.random() < burst:
            left = int(rng.integers(1, 41))
        gone, packet = min(left, len(packet)), packet[min(left, len(packet)) :]
        left -= gone
        faults = np.flatnonzero(rng.random(len(packet)) < byte)[::-1].tolist()
        if faults:
            data = bytearray(packet)
            for at in faults:
                kind = rng.integers(4)
                if kind < 2:
                    data[at] ^= 1 << int(rng.integers(8))
                elif kind == 2:
                    del data[at]
                else:
                    data[at + 1 : at + 1] = rng.bytes(1)
            packet = bytes(data)
        out.append(packet)
    return out


def judge(
    name: str, extra: dict[str, Any], packets: int, seed: int = 0, byte: float = BYTE, burst: float = BURST
) -> Judged:
    """Send so many packets of a format over the cable, and judge all frames that come out."""
    rng, found = np.random.default_rng(seed), Judged(name)
    for number in range(-(-packets // ONCE)):
        sent, _ = stream(name, extra, ONCE, seed + number)
        truth = pair(name, extra)[0]
        clean = [(one.values.tobytes(), one.device, one.sequence) for part in sent for one in truth.feed(part)]
        clean += [(one.values.tobytes(), one.device, one.sequence) for one in truth.finish()]
        arrived = damage(sent, rng, byte, burst)
        found.damaged += sum(a != b for a, b in zip(sent, arrived, strict=True))
        decoder = pair(name, extra)[0]
        got = [one for part in arrived for one in decoder.feed(part)] + decoder.finish()
        places: dict[Any, list[int]] = {}
        for place, frame in enumerate(clean):
            places.setdefault(frame, []).append(place)
        last = -1
        for one in got:
            here = places.get((one.values.tobytes(), one.device, one.sequence), [])
            later = next((place for place in here if place > last), -1)
            if later < 0:
                found.false += 1
            else:
                found.right, last = found.right + 1, later
        found.sent += len(clean)
        found.said += decoder.counts.missing
    return found
