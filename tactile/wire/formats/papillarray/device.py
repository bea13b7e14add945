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

from tactile.wire.base import Encoder, Options, Taxels
from tactile.wire.device_tare import DeviceTare
from tactile.wire.formats.papillarray.packet import END, HUB, PILLAR, START, WHOLE

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
        self._forms: dict[tuple[tuple[int, int], bool], Form] = {}

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
        shape, order = (len(boards), len(boards[0])), int(self._displacement_first)
        form = self._forms.get((shape, self._slip))
        if form is None:
            form = self._forms[shape, self._slip] = Form(*shape, self._entry, self._slip)
        values = np.array(boards)
        HUB.pack_into(form.payload, form.hub, counter, round(t_device * 1e6))
        form.triples[:, :, order], form.triples[:, :, 1 - order] = values, values / 10
        form.force[:] = values.sum(1)
        payload = bytes(form.payload)
        return START + payload + struct.pack("<H", sum(payload) & 0xFFFF) + END


class Form:
    """A payload of so many sensors of so many pillars, and where in it the numbers go that change.

    ``hub`` the place of counter and time; ``triples`` (sensors, pillars, 2, 3), ``force`` (sensors, 3): views.
    """

    def __init__(self, sensors: int, pillars: int, entry: bytes, slip: bool) -> None:
        state = IN_CONTACT if slip else INELIGIBLE
        pillar, whole = np.zeros((), PILLAR), np.zeros((), WHOLE)
        pillar["kind"], whole["kind"], whole["torque"] = 2, 2, (1, 2, 3)
        each = _nested([pillar.tobytes()] * pillars)
        slips = _nested([b"\x01\x00" + struct.pack("<bf", state, -1.0)] * pillars)
        grip = entry + struct.pack("<bff", 2 if slip else 0, 0.5, -1.0)
        blocks = {1: bytes(HUB.size), 3: _nested([each] * sensors), 4: _nested([whole.tobytes()] * sensors),
                  5: _nested([slips] * sensors), 6: _nested([grip] * sensors)}  # fmt: skip
        at, table, places = 1 + 4 * len(blocks) + 2, b"\x02", {}
        for kind, block in blocks.items():
            table, places[kind] = table + struct.pack("<HH", kind, at), at
            at += len(block)
        self.payload = bytearray(table + b"\0\0" + b"".join(blocks.values()))
        self.hub, heads = places[1], 2 + 2 * sensors
        self.triples = np.ndarray(
            (sensors, pillars, 2, 3), "<f4", self.payload, places[3] + heads + 2 + 2 * pillars + 2,
            (len(each), PILLAR.itemsize, 12, 4),
        )  # fmt: skip
        self.force = np.ndarray((sensors, 3), "<f4", self.payload, places[4] + heads + 2, (WHOLE.itemsize, 4))


def _nested(entries: list[bytes]) -> bytes:
    """Return count, offsets from the block's start, entries."""
    at, offsets = 2 + 2 * len(entries), b""
    for entry in entries:
        offsets += struct.pack("<H", at)
        at += len(entry)
    return struct.pack("<H", len(entries)) + offsets + b"".join(entries)
