"""The inside of a PTSCOM 2.0 packet: its table of blocks and what each block holds.

Payload, little endian: u8 w; entries {u16 type, offset of w bytes} and a closing u16 0. Offsets count from the first
byte after the start marker. Blocks of type

    1  u32 packet counter, u64 time [us]
    3  Ns; for every sensor Np; for every pillar u16 2 and six float32, forces [N] and displacements [mm]
    4  Ns; for every sensor u16 2 and six float32: Fx Fy Fz [N], Tx Ty Tz [N mm]
    5  Ns; for every sensor Np; for every pillar u16 1, int8 slip state, float32 friction
    6  Ns; for every sensor an entry type of 1 or 2 bytes, int8 state, float32 friction, float32 wanted grip force

Ns and Np are u16, each followed by as many offsets of w bytes. What these nested offsets count from differs between
devices, so the blocks are read one entry after the other and the nested offsets are left alone.

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


class WrongPacketError(Exception):
    """The payload is not built as it says."""


@dataclass(frozen=True)
class Packet:
    """What the pipeline and the settling need of a packet.

    ``triples`` (sensors, pillars, 2, 3): force and displacement in either order; ``force`` (sensors, 3) [N] of the
    whole sensors, None where the block is missing; ``entry`` 1 or 2, the bytes of a type 6 entry's type, None where
    neither fits.
    """

    counter: int
    micros: int
    triples: Floats
    force: Floats | None
    entry: int | None


def read_packet(payload: bytes) -> Packet:
    """Return what a payload holds.

    Raises:
        WrongPacketError: a table, a count or a block that does not fit into it.
    """
    try:
        width, blocks = _blocks(payload)
        counter, micros = HUB.unpack_from(blocks[1])
        triples = _pillars(blocks[3], width)
        force = _whole(blocks[4], width)["force"].astype(np.float64) if 4 in blocks else None
        entry = _entry(blocks[6], width) if 6 in blocks else None
    except (struct.error, ValueError, KeyError, IndexError) as error:
        raise WrongPacketError(str(error)) from error
    return Packet(counter, micros, triples.astype(np.float64), force, entry)


def _blocks(payload: bytes) -> tuple[int, dict[int, bytes]]:
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
    return width, {kind: payload[start : ends[ends.index(start) + 1]] for kind, start in found.items()}


def _pillars(block: bytes, width: int) -> NDArray[np.float32]:
    (sensors,) = struct.unpack_from("<H", block)
    at, all_sensors = 2 + sensors * width, []
    for _ in range(sensors):
        (pillars,) = struct.unpack_from("<H", block, at)
        at += 2 + pillars * width
        table = np.frombuffer(block, PILLAR, pillars, at)
        at += table.nbytes
        if (table["kind"] != 2).any():
            raise WrongPacketError("an entry of the pillars' block is no pillar")
        all_sensors.append(table["triples"])
    if not sensors or len({len(one) for one in all_sensors}) > 1:
        raise WrongPacketError(f"{sensors} sensors, with {[len(one) for one in all_sensors]} pillars")
    return np.stack(all_sensors)


def _whole(block: bytes, width: int) -> NDArray[np.void]:
    (sensors,) = struct.unpack_from("<H", block)
    return np.frombuffer(block, WHOLE, sensors, 2 + sensors * width)


def _entry(block: bytes, width: int) -> int | None:
    """Return which width of the entries' type fits: by the block's length, and by states that are 0, 1 or 2."""
    (sensors,) = struct.unpack_from("<H", block)
    at = 2 + sensors * width
    for size in (1, 2):
        states = [block[at + (size + 9) * n + size] for n in range(sensors) if at + (size + 9) * (n + 1) <= len(block)]
        if at + (size + 9) * sensors == len(block) and all(state in (0, 1, 2, 255) for state in states):
            return size
    return None
