"""Contactile PapillArray hubs: PTSCOM 2.0 packets with a checksum, a counter and device time.

    55 66 77 88 | payload (`papillarray.packet`) | u16 sum of the payload's bytes | AA BB CC DD

There is no length and no escaping, so both markers may occur inside a float. At every end marker each earlier start
marker is tried, the first one first; a packet needs the right checksum and structure. Random bytes pass the checksum
once in 65 536 times, but hardly the structure.

The manual and the vendor's host differ on two points, which the decoder finds from the data: whether the first triple
of a pillar is its force or its displacement (forces of pillars add up to that of the sensor), and whether the type of a
slip entry has one byte or two (from the length of the block). Before a load decides, the first triple is the force.
"""

from typing import Any

import numpy as np

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Found, Options, Talk
from tactile.wire.formats.papillarray.device import PapillarrayEncoder
from tactile.wire.formats.papillarray.packet import (
    END,
    HUB,
    PILLAR,
    START,
    WHOLE,
    Packet,
    read_packet,
)
from tactile.wire.reading import Reading
from tactile.wire.registry import Format

LONGEST = 16384
"""Longest packet in bytes, or twice that of a larger device; two sensors of nine pillars need 817."""
LARGEST = 2**16
"""Largest packet with offsets of 16 bits, as hubs send them."""
SHORTEST = 4 + 1 + 2 + 2 + 4
NEAR, FAR = 0.05, 0.5
"""[N] Largest error of the sum of the right triples, and least error of the wrong ones, that decide their order."""
ORDERS = ("force first, as the vendor's host reads it", "displacement first, as the manual draws it")


class PapillarrayDecoder(Decoder):
    """Decodes packets into the forces [N] of all sensors' pillars, one sensor after the other."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels = options.taxels
        self._longest = max(LONGEST, 2 * _packet_size(options))
        self._searched = 0  # end markers before this position have been tried
        self._order: int | None = None
        self._entry: int | None = None

    def settled(self) -> dict[str, Any]:
        """Return the two points on which manual and host differ, None while unknown."""
        order = None if self._order is None else ORDERS[self._order]
        return {"pillar": order, "slip_entry_type_bytes": self._entry}

    def _restart(self) -> None:
        self._searched = 0

    def _next(self, over: bool) -> Found | None:
        data = self._buffer
        while (mark := data.find(END, self._searched)) >= 0:
            if (found := self._ending_at(mark)) is not None:
                return found
            self._searched = mark + 1
        self._searched = max(self._searched, len(data) - len(END) + 1)
        return self._stale()

    def _ending_at(self, mark: int) -> Found | None:
        """Return the packet that ends with the marker at ``mark``, if any start marker before it fits."""
        data, end = self._buffer, mark + len(END)
        start = data.find(START, max(0, end - self._longest), mark)
        if start < 0:
            return None
        wanted = int.from_bytes(data[mark - 2 : mark], "little")
        total = sum(data[start + 4 : mark - 2])
        while end - start >= SHORTEST:
            if total & 0xFFFF == wanted and (packet := read_packet(bytes(data[start + 4 : mark - 2]))) is not None:
                return self._found(start, end, packet)
            later = data.find(START, start + 1, mark)
            if later < 0:
                break
            total -= sum(data[start + 4 : later + 4])  # bounds the cost of many markers
            start = later
        return None

    def _found(self, start: int, end: int, packet: Packet) -> Found:
        self.counts.bad_checksum += self._buffer.count(START, 0, start)
        self._searched = 0
        if packet.triples.shape[:2] != (len(self._taxels), self._taxels[0]) or len(set(self._taxels)) > 1:
            sensors, pillars = packet.triples.shape[:2]
            self._count_unfit(f"{sensors} sensors of {pillars} pillars")
            return Found(end)
        self._settle(packet)
        values = packet.triples[:, :, self._order or 0].reshape(-1, 3)
        # two changes may cancel in a byte sum, so a jump of the counter needs confirmation
        place = self._begin + end
        return Found(start, end - start, Reading(values, place, None, packet.counter, packet.micros * 1e-6, False))

    def _stale(self) -> Found | None:
        """Drop bytes that can no longer be part of a packet."""
        data = self._buffer
        oldest = max(0, len(data) - self._longest + 1)
        keep = data.find(START, oldest)
        if keep < 0:
            tails = (len(data) - n for n in range(min(3, len(data) - oldest), 0, -1) if data.endswith(START[:n]))
            keep = next(tails, len(data))
        if keep == 0:
            return None
        self.counts.bad_checksum += data.count(START, 0, min(keep + 3, len(data)))
        self._searched = max(0, self._searched - keep)
        return Found(keep)

    def _settle(self, packet: Packet) -> None:
        self._entry = self._entry or packet.entry
        if self._order is None and packet.force is not None and len(packet.force) == len(packet.triples):
            off = np.abs(packet.triples.sum(1) - packet.force[:, None]).max((0, 2))  # of either triple
            right = int(off.argmin())
            if off[right] < NEAR and off[1 - right] > FAR:
                self._order = right


def _packet_size(options: Options) -> int:
    """Return the bytes of a packet from this device, offsets of 2 bytes.

    Raises:
        InputError: sensors of different shapes, or more pillars than 16 bits can point at.
    """
    if len(set(options.shapes)) > 1:
        shapes = ", ".join(f"{rows} x {cols}" for rows, cols in options.shapes)
        raise InputError(f"papillarray: sensors of {shapes} pillars; all of one shape wanted")
    block = 2 + 2  # a block's count of sensors, a sensor's offset in it
    pillar = 2 + PILLAR.itemsize + 2 + 2 + 1 + 4
    sensor = 4 * block + 2 * 2 + WHOLE.itemsize + 2 + 1 + 4 + 4 + pillar * options.taxels[0]
    size = SHORTEST + 6 * 4 + HUB.size + len(options.shapes) * sensor
    if size > LARGEST:
        raise InputError(
            f"papillarray: {len(options.shapes)} sensors of {options.taxels[0]} pillars make packets of {size} bytes;"
            f" {LARGEST} at most wanted"
        )
    return size


def _talk(options: Options) -> Talk:
    rate = options.extra.get("rate_hz")
    return Talk(b"" if rate is None else f"f{rate}\n".encode())


FORMATS = {
    "papillarray": Format(
        "papillarray",
        "Contactile PapillArray hubs, PTSCOM 2.0",
        9600,
        1.0,
        PapillarrayDecoder,
        PapillarrayEncoder,
        _talk,
        ("pillar", "slip_entry", "rate_hz"),
        fingers=tuple(
            {"name": f"sensor-{n}", "rows": 3, "cols": 3, "pitch_mm": 7.0, "depth_mm": 0.0, "quantity": "force"}
            for n in range(2)
        ),
    )
}
