"""Payload of a PTSCOM 2.0 packet: its table of blocks and their contents.

Payload, little endian: u8 w; entries {u16 type, offset of w bytes} and a closing u16 0. Offsets count from the first
byte after the start marker. Blocks of type

    1  u32 packet counter, u64 time [us]
    3  Ns; for every sensor Np; for every pillar u16 2 and six float32, forces [N] and displacements [mm]
    4  Ns; for every sensor u16 2 and six float32: Fx Fy Fz [N], Tx Ty Tz [N mm]
    5  Ns; for every sensor Np; for every pillar u16 1, int8 slip state, float32 friction
    6  Ns; for every sensor an entry type of 1 or 2 bytes, int8 state, float32 friction, float32 wanted grip force

Ns and Np are u16, each followed by as many offsets of w bytes. The origin of these nested offsets differs between
devices, so the blocks are read entry by entry and the nested offsets are ignored.

Sources: PTSCOM 2.0 specification (Contactile, September 2022); contactile-papillarray-ros2 ``protocol.py``.
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats

START, END = bytes.fromhex("55667788"), bytes.fromhex("aabbccdd")
PILLAR = np.dtype([("kind", "<u2"), ("triples", "<f4", (2, 3))])
WHOLE = np.dtype([("kind", "<u2"), ("force", "<f4", 3), ("torque", "<f4", 3)])
HUB = struct.Struct("<IQ")
WIDTHS = {1: "B", 2: "H", 4: "I"}
Places = NDArray[np.intp]
Span = tuple[int, int]
"""The places of a block in the payload: from, up to."""


class WrongPacketError(Exception):
    """The payload has an invalid structure."""


@dataclass(frozen=True)
class Packet:
    """Contents of a packet.

    ``triples`` (sensors, pillars, 2, 3): force and displacement in either order; ``force`` (sensors, 3) [N] of whole
    sensors, None without the block; ``entry`` 1 or 2, the bytes of the type of a type 6 entry, None where neither fits.
    """

    counter: int
    micros: int
    triples: Floats
    force: Floats | None
    entry: int | None


@dataclass(frozen=True)
class Layout:
    """Byte positions in payloads of one structure; a device always sends the same, so it is found once.

    ``fixed`` positions of the bytes equal in all of them: table, counts, offsets and types of the blocks; ``told``
    these bytes.
    """

    length: int
    fixed: Places
    told: bytes
    hub: int
    triples: Places
    force: Places | None
    entry: int | None
    entry_open: bool

    def fits(self, payload: bytes, data: NDArray[np.uint8]) -> bool:
        """Return whether a payload has this structure."""
        return len(payload) == self.length and data.take(self.fixed).tobytes() == self.told and not self.entry_open

    def read(self, payload: bytes, data: NDArray[np.uint8]) -> Packet:
        """Return the contents of a payload of this structure."""
        counter, micros = HUB.unpack_from(payload, self.hub)
        triples = data.take(self.triples).view("<f4")[..., 0].astype(np.float64)
        force = None if self.force is None else data.take(self.force).view("<f4")[..., 0].astype(np.float64)
        return Packet(counter, micros, triples, force, self.entry)


class PacketReader:
    """Reads payloads one after another."""

    def __init__(self) -> None:
        self._layout: Layout | None = None

    def __call__(self, payload: bytes) -> Packet:
        """Return the contents of a payload.

        Raises:
            WrongPacketError: a table, a count or a block that does not fit.
        """
        data = np.frombuffer(payload, np.uint8)
        if self._layout is None or not self._layout.fits(payload, data):
            try:
                self._layout = _lay_out(payload, data)
            except (struct.error, ValueError, KeyError, IndexError) as error:
                raise WrongPacketError(str(error)) from error
        return self._layout.read(payload, data)


def _lay_out(payload: bytes, data: NDArray[np.uint8]) -> Layout:
    width, table, blocks = _blocks(payload)
    hub, end = blocks[1]
    if end - hub < HUB.size:
        raise WrongPacketError(f"a hub's block of {end - hub} bytes; {HUB.size} wanted")
    triples, last = _pillars(payload, blocks[3], width)
    force, whole = _whole(payload, blocks[4], width) if 4 in blocks else (None, 0)
    fixed = np.zeros(len(payload), bool)
    fixed[:table] = fixed[blocks[3][0] : last] = True
    if force is not None:
        fixed[blocks[4][0] : whole] = True
        fixed[force] = fixed[force + 3 * 4] = False  # forces and torques
    fixed[triples] = False
    entry = _entry(payload[slice(*blocks[6])], width) if 6 in blocks else None
    places = np.flatnonzero(fixed)
    told = data[places].tobytes()
    return Layout(len(payload), places, told, hub, triples, force, entry, 6 in blocks and entry is None)


def _blocks(payload: bytes) -> tuple[int, int, dict[int, Span]]:
    """Return the width of offsets, the length of the table, and where each kind of block is."""
    width = payload[0]
    entry = struct.Struct("<H" + WIDTHS[width])
    found, at = {}, 1
    while struct.unpack_from("<H", payload, at)[0]:
        kind, offset = entry.unpack_from(payload, at)
        found[kind] = offset
        at += entry.size
    ends = [*sorted(found.values()), len(payload)]
    if min(ends) < at + 2 or max(ends) > len(payload):
        raise WrongPacketError(f"blocks from {min(ends)} to {max(ends)} in {len(payload)} bytes")
    return width, at + 2, {kind: (start, ends[ends.index(start) + 1]) for kind, start in found.items()}


def _pillars(payload: bytes, span: Span, width: int) -> tuple[Places, int]:
    """Return the place of every byte of the triples, (sensors, pillars, 2, 3, 4), and where the last one ends."""
    (start, end), starts, counts = span, [], []
    (sensors,) = _number(payload, start, end)
    at = start + 2 + sensors * width
    for _ in range(sensors):
        (pillars,) = _number(payload, at, end)
        at += 2 + pillars * width
        if at + pillars * PILLAR.itemsize > end:
            raise WrongPacketError(f"{pillars} pillars in {end - at} bytes")
        starts += [at + n * PILLAR.itemsize for n in range(pillars)]
        counts.append(pillars)
        at += pillars * PILLAR.itemsize
    if any(_number(payload, place, end) != (2,) for place in starts):
        raise WrongPacketError("an entry of the pillars' block is no pillar")
    if not sensors or len(set(counts)) > 1:
        raise WrongPacketError(f"{sensors} sensors, with {counts} pillars")
    within = 2 + np.arange(2 * 3 * 4).reshape(2, 3, 4)
    return np.array(starts, np.intp).reshape(sensors, counts[0], 1, 1, 1) + within, at


def _whole(payload: bytes, span: Span, width: int) -> tuple[Places, int]:
    """Return the place of every byte of the sensors' forces, (sensors, 3, 4), and where the last sensor ends."""
    start, end = span
    (sensors,) = _number(payload, start, end)
    at = start + 2 + sensors * width
    last = at + sensors * WHOLE.itemsize
    if last > end:
        raise WrongPacketError(f"{sensors} sensors in {end - at} bytes")
    return at + np.arange(sensors).reshape(-1, 1, 1) * WHOLE.itemsize + 2 + np.arange(3 * 4).reshape(3, 4), last


def _number(payload: bytes, at: int, end: int) -> tuple[int]:
    if at + 2 > end:
        raise WrongPacketError(f"a number at byte {at} of a block that ends at {end}")
    return struct.unpack_from("<H", payload, at)


def _entry(block: bytes, width: int) -> int | None:
    """Return which width of the entries' type fits: by the block's length, and by states that are 0, 1 or 2."""
    (sensors,) = struct.unpack_from("<H", block)
    at = 2 + sensors * width
    for size in (1, 2):
        states = [block[at + (size + 9) * n + size] for n in range(sensors) if at + (size + 9) * (n + 1) <= len(block)]
        if at + (size + 9) * sensors == len(block) and all(state in (0, 1, 2, 255) for state in states):
            return size
    return None
