"""Emulated PapillArray hub (PTSCOM 2.0): packets, and the commands of the specification.

    z\\n  bias: zero the readings; nothing may touch the sensors for up to 2 s
    S\\n  start slip detection      s\\n  stop it
    f100\\n f250\\n f500\\n f1000\\n  packets per second

Other text is ignored. Source: PTSCOM 2.0 specification (Contactile, September 2022).
"""

import math
import struct
from collections.abc import Sequence

import numpy as np

from cnnsim.support import Floats
from tactile.wire.base import Encoder, Options
from tactile.wire.device_tare import DeviceTare
from tactile.wire.formats.papillarray.packet import END, HUB, PILLAR, START, WHOLE
from tactile.wire.reading import Taxels

BIAS = 2.0
"""[s] Averaging time of the hub."""
RATES = (100, 250, 500, 1000)
INELIGIBLE, IN_CONTACT = -2, 2
"""A pillar's slip state without slip detection and with it."""


class PapillarrayEncoder(Encoder):
    """Encodes packets; options ``pillar`` ("force first", "displacement first") and ``slip_entry`` (2 or 1 bytes)."""

    def __init__(self, options: Options) -> None:
        self._displacement_first = options.extra.get("pillar", "force first") == "displacement first"
        self._entry = b"\x01\x00" if options.extra.get("slip_entry", 2) == 2 else b"\x01"
        self._tare, self._slip = DeviceTare(BIAS), True
        self._received = bytearray()
        self._period, self._due, self._left_out = 0.0, -math.inf, 0

    def receive(self, data: bytes) -> bytes:
        """Obey the lines that are complete; the hub answers nothing."""
        self._received += data
        *lines, rest = bytes(self._received).split(b"\n")
        self._received[:] = rest[-16:]
        for line in lines:
            if line == b"z":
                self._tare.ask()
            elif line in (b"S", b"s"):
                self._slip = line == b"S"
            elif line[:1] == b"f" and line[1:].isdigit() and int(line[1:]) in RATES:
                self._period, self._due = 1 / int(line[1:]), -math.inf
        return b""

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one packet with all sensors; a displacement [mm] is a tenth of its force [N]."""
        boards = self._tare(boards, t_device)
        if self._period and t_device < self._due - 1e-9:
            self._left_out += 1  # the hub counts what it sends
            return b""
        self._due = (self._due if t_device - self._due < self._period else t_device) + self._period
        counter = (sequence - self._left_out) % 2**32
        payload = self._payload(HUB.pack(counter, round(t_device * 1e6)), np.array(boards))
        return START + payload + struct.pack("<H", sum(payload) & 0xFFFF) + END

    def _payload(self, hub: bytes, values: Floats) -> bytes:
        """Return the payload for (sensors, pillars, 3) forces."""
        sensors, order = len(values), int(self._displacement_first)
        pillars, whole = np.zeros(values.shape[:2], PILLAR), np.zeros(sensors, WHOLE)
        pillars["kind"], whole["kind"], whole["torque"] = 2, 2, (1, 2, 3)
        pillars["triples"][:, :, order], pillars["triples"][:, :, 1 - order] = values, values / 10
        whole["force"] = values.sum(1)
        slip = struct.pack("<Hbf", 1, IN_CONTACT if self._slip else INELIGIBLE, -1.0)
        grip = self._entry + struct.pack("<bff", 2 if self._slip else 0, 0.5, -1.0)
        blocks = {
            1: hub,
            3: _nested([_nested([one.tobytes() for one in sensor]) for sensor in pillars]),
            4: _nested([one.tobytes() for one in whole]),
            5: _nested([_nested([slip] * values.shape[1])] * sensors),
            6: _nested([grip] * sensors),
        }
        at, table = 1 + 4 * len(blocks) + 2, b"\x02"
        for kind, block in blocks.items():
            table += struct.pack("<HH", kind, at)
            at += len(block)
        return table + b"\0\0" + b"".join(blocks.values())


def _nested(entries: list[bytes]) -> bytes:
    """Return count, offsets from the block's start, entries."""
    at, offsets = 2 + 2 * len(entries), b""
    for entry in entries:
        offsets += struct.pack("<H", at)
        at += len(entry)
    return struct.pack("<H", len(entries)) + offsets + b"".join(entries)
