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
from typing import Any

import numpy as np

from cnnsim.support import Floats

START, END = bytes.fromhex("55667788"), bytes.fromhex("aabbccdd")
PILLAR = np.dtype([("kind", "<u2"), ("triples", "<f4", (2, 3))])
WHOLE = np.dtype([("kind", "<u2"), ("force", "<f4", 3), ("torque", "<f4", 3)])
HUB = struct.Struct("<IQ")
WIDTHS = {1: "B", 2: "H", 4: "I"}
Span = tuple[int, int]
"""The places of a block in the payload: from, up to."""


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


def read_packet(payload: bytes) -> Packet | None:
    """Return the contents of a payload, None if a table, a count or a block does not fit."""
    try:
        width, blocks = _blocks(payload)
        hub, end = blocks[1]
        if end - hub < HUB.size:
            raise ValueError(f"a hub's block of {end - hub} bytes; {HUB.size} wanted")
        counter, micros = HUB.unpack_from(payload, hub)
        triples = _pillars(payload, blocks[3], width)
        force = _whole(payload, blocks[4], width) if 4 in blocks else None
        entry = _entry(payload[slice(*blocks[6])], width) if 6 in blocks else None
    except (struct.error, ValueError, KeyError, IndexError):
        return None
    return Packet(counter, micros, triples, force, entry)


def _blocks(payload: bytes) -> tuple[int, dict[int, Span]]:
    """Return the width of offsets, and where each kind of block is."""
    width = payload[0]
    entry = struct.Struct("<H" + WIDTHS[width])
    found, at = {}, 1
    while struct.unpack_from("<H", payload, at)[0]:
        kind, offset = entry.unpack_from(payload, at)
        found[kind] = offset
        at += entry.size
    ends = [*sorted(found.values()), len(payload)]
    if min(ends) < at + 2 or max(ends) > len(payload):
        raise ValueError(f"blocks from {min(ends)} to {max(ends)} in {len(payload)} bytes")
    return width, {kind: (start, ends[ends.index(start) + 1]) for kind, start in found.items()}


def _pillars(payload: bytes, span: Span, width: int) -> Floats:
    """Return (sensors, pillars, 2, 3) triples."""
    start, end = span
    tables: list[Any] = []
    (sensors,) = _number(payload, start, end)
    at = start + 2 + sensors * width
    for _ in range(sensors):
        (pillars,) = _number(payload, at, end)
        at += 2 + pillars * width
        if at + pillars * PILLAR.itemsize > end:
            raise ValueError(f"{pillars} pillars in {end - at} bytes")
        tables.append(np.frombuffer(payload, PILLAR, pillars, at))
        at += pillars * PILLAR.itemsize
    if not sensors or len({len(table) for table in tables}) > 1:
        raise ValueError(f"{sensors} sensors, with {[len(table) for table in tables]} pillars")
    whole = np.stack(tables)
    if (whole["kind"] != 2).any():
        raise ValueError("an entry of the pillars' block is no pillar")
    triples: Floats = whole["triples"].astype(np.float64)
    return triples


def _whole(payload: bytes, span: Span, width: int) -> Floats:
    """Return (sensors, 3) forces of whole sensors."""
    start, end = span
    (sensors,) = _number(payload, start, end)
    at = start + 2 + sensors * width
    if at + sensors * WHOLE.itemsize > end:
        raise ValueError(f"{sensors} sensors in {end - at} bytes")
    force: Floats = np.frombuffer(payload, WHOLE, sensors, at)["force"].astype(np.float64)
    return force


def _number(payload: bytes, at: int, end: int) -> tuple[int]:
    if at + 2 > end:
        raise ValueError(f"a number at byte {at} of a block that ends at {end}")
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
