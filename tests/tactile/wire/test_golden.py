"""Golden vectors of every wire format, decoded and encoded."""

import json
import struct
from typing import Any

import numpy as np
import pytest

from tactile.wire.base import Decoder, Encoder, Options
from tactile.wire.reading import Reading
from tactile.wire.registry import find_format
from tests.kits.paths import ROOT
from tests.kits.wire import decoded, pair


def golden() -> dict[str, Any]:
    path = ROOT / "tests" / "oracles" / "wire_vectors.json"
    return json.loads(path.read_text(encoding="utf-8"))


def read_golden(key: str, name: str, extra: dict[str, Any] | None = None) -> tuple[list[Reading], Decoder, Encoder]:
    decoder, encoder = pair(name, extra)
    return decoded(decoder, bytes.fromhex(golden()[key]["hex"])), decoder, encoder


@pytest.mark.parametrize("key", ["reskin5", "reskin5_crlf_in_payload"])
def test_golden_reskin(key: str) -> None:
    (reading,), _, encoder = read_golden(key, "reskin")
    chips = np.array(golden()[key]["values"], np.float32).reshape(5, 4)
    assert np.array_equal(reading.values, chips[:, 1:])
    sent = bytearray(encoder.encode([reading.values], 0, 0.0))
    for chip in range(5):  # the encoder writes one temperature for all chips
        sent[16 * chip : 16 * chip + 4] = struct.pack("<f", chips[chip, 0])
    assert sent.hex() == golden()[key]["hex"]


@pytest.mark.parametrize(("key", "extra"), [
    ("papill_FD", {}), ("papill_DF", {"pillar": "displacement first", "slip_entry": 1}),
])  # fmt: skip
def test_golden_papillarray(key: str, extra: dict[str, Any]) -> None:
    (reading,), decoder, encoder = read_golden(key, "papillarray", extra)
    pillars = [[pillar[0] for pillar in sensor["pillars"]] for sensor in golden()[key]["sensors"]]
    assert np.array_equal(reading.values, np.array(pillars, np.float32).reshape(18, 3))
    assert (reading.sequence, reading.t_device) == (42, 123456e-6)
    assert decoder.settled()["slip_entry_type_bytes"] == extra.get("slip_entry", 2)
    exact = np.array(pillars)  # sums of single-precision values differ in the last bit
    assert encoder.encode(list(exact), 42, 123456e-6).hex() == golden()[key]["hex"]


def test_golden_paxini() -> None:
    for key, name in (("paxini_hs_push", "paxini-fast"), ("paxini_fin_resp9", "paxini-serial")):
        (reading,), _, encoder = read_golden(key, name)
        points = np.array(golden()["paxini_fin_resp9"]["points"])
        assert np.array_equal(np.rint(reading.values / 0.1), points)
        sent = encoder.encode([reading.values], 0, 0.0)
        if name == "paxini-fast":  # the resultant in the vector is not the points' sum
            assert sent[12:-1].hex() == golden()[key]["hex"][24:-2]
        else:
            assert sent.hex() == golden()[key]["hex"]
    fast, slow = (find_format(name).talk(Options(((3, 3),))) for name in ("paxini-fast", "paxini-serial"))
    assert fast.hello.hex().endswith(golden()["paxini_hs_autopush_on"]["hex"])
    assert slow.poll.hex() == golden()["paxini_fin_read9"]["hex"]


def test_golden_lowiek() -> None:
    (reading,), _, encoder = read_golden("lowiek_2x2", "lowiek")
    words = np.array(golden()["lowiek_2x2"]["raw_twos_complement"]).reshape(4, 3)
    assert np.array_equal(reading.values, words * [0.150, 0.150, 0.242])
    assert encoder.encode([reading.values], 0, 0.0).hex() == golden()["lowiek_2x2"]["hex"]


def test_golden_native() -> None:
    """Computed by hand from the format's table: 1 x 1 taxel, int16 values 1, -1, 0."""
    packet = bytes.fromhex("01 00 01 01 00 07000000 40e2010000000000 0100 ffff 0000".replace(" ", ""))
    crc = _crc16(packet)
    shape = Options(((1, 1),), {"value": "int16"})
    sent = find_format("native").encoder(shape).encode([np.array([[1.0, -1.0, 0.0]])], 7, 0.123456)
    assert sent == _cobs(packet + struct.pack("<H", crc)) + b"\0"
    (reading,) = find_format("native").decoder(shape).feed(sent)
    assert (reading.values.tolist(), reading.sequence, reading.device) == ([[1, -1, 0]], 7, 0)
    assert reading.t_device == pytest.approx(0.123456, abs=1e-12)
    assert _crc16(b"123456789") == 0x29B1  # the catalogue's check value of CRC-16/IBM-3740


def _crc16(data: bytes) -> int:
    register = 0xFFFF
    for byte in data:
        register ^= byte << 8
        for _ in range(8):
            register = (register << 1 ^ (0x1021 if register & 0x8000 else 0)) & 0xFFFF
    return register


def _cobs(data: bytes) -> bytes:
    return b"".join(bytes([len(run) + 1]) + run for run in data.split(b"\0"))
