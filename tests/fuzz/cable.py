"""Frames over a bad cable: every frame that a decoder gives out is held against what was sent.

The cable, per byte: with probability `BYTE` one bit is changed (half of the faults), the byte is lost (a quarter), or
one at random comes after it (a quarter); and before each packet, with probability `BURST`, 1 to 40 bytes are lost, as
where a buffer ran over.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactile.wire.reading import Reading
from tests.kits.wire import decoded, pair, stream

BYTE, BURST = 1e-4, 1e-3
ONCE, STREAMS = 4000, 8
"""Packets that one decoder sees, and how many such streams there are; each has its own random damage."""


@dataclass
class Judged:
    """What became of the frames of a format.

    ``sent``; ``damaged`` packets that the cable touched; ``right`` frames, as they were sent; ``false`` ones, with
    values or a counter that were not sent, or out of order; ``lost`` frames; ``said`` of them, by the decoder's count.
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
    ends = np.cumsum([len(packet) for packet in packets])
    starts = np.concatenate(([0], ends[:-1]))
    lost = np.zeros(int(ends[-1]), bool)
    for start in starts[rng.random(len(packets)) < burst].tolist():
        lost[start : start + int(rng.integers(1, 41))] = True
    faults = np.flatnonzero((rng.random(lost.size) < byte) & ~lost)
    places = np.union1d(faults, np.flatnonzero(lost))
    out, touched = list(packets), np.searchsorted(ends, places, "right")
    for number in np.unique(touched).tolist():
        start, data = int(starts[number]), bytearray(packets[number])
        for place in places[touched == number][::-1].tolist():
            at, kind = place - start, 2 if lost[place] else rng.integers(4)
            if kind < 2:
                data[at] ^= 1 << int(rng.integers(8))
            elif kind == 2:
                del data[at]
            else:
                data[at + 1 : at + 1] = rng.bytes(1)
        out[number] = bytes(data)
    return out


@dataclass
class Stream:
    """Packets, the frames that they are made of, and at which places of the stream each of these comes."""

    packets: list[bytes]
    frames: int
    places: dict[Any, list[int]]

    @classmethod
    def of(cls, name: str, extra: dict[str, Any], count: int, seed: int) -> "Stream":
        """Make a stream of a format."""
        packets, _ = stream(name, extra, count, seed)
        clean = [_identity(one) for one in decoded(pair(name, extra)[0], *packets)]
        places: dict[Any, list[int]] = {}
        for place, frame in enumerate(clean):
            places.setdefault(frame, []).append(place)
        return cls(packets, len(clean), places)


def _identity(one: Reading) -> tuple[bytes, int | None, int | None]:
    return one.values.tobytes(), one.device, one.sequence


def judge(
    name: str, extra: dict[str, Any], packets: int, seed: int = 0, byte: float = BYTE, burst: float = BURST
) -> Judged:
    """Send a number of packets of a format over the cable, and judge all decoded frames."""
    rng, found = np.random.default_rng(seed), Judged(name)
    streams = [Stream.of(name, extra, ONCE, seed + n) for n in range(min(STREAMS, -(-packets // ONCE)))]
    for number in range(-(-packets // ONCE)):
        sent = streams[number % len(streams)]
        arrived = damage(sent.packets, rng, byte, burst)
        found.damaged += sum(a != b for a, b in zip(sent.packets, arrived, strict=True))
        decoder, last = pair(name, extra)[0], -1
        for one in decoded(decoder, *arrived):
            later = next((place for place in sent.places.get(_identity(one), []) if place > last), -1)
            if later < 0:
                found.false += 1
            else:
                found.right, last = found.right + 1, later
        found.sent += sent.frames
        found.said += decoder.counts.missing
    return found
