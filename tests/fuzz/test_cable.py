"""False frames over a bad cable stay within what each format's own sums allow, and most frames come through."""

from typing import Any

import numpy as np
import pytest

from tests.fuzz.cable import damage, judge
from tests.kits.wire import VARIANTS, stream

ALLOWED = {"native": 0.0, "papillarray": 2**-10, "paxini-fast": 2**-6, "paxini-serial": 2**-6, "csv+check": 2**-5,
           "csv": 0.7, "reskin": 0.7, "lowiek": 1.0}  # fmt: skip
"""False frames for each damaged packet: none with a CRC; sums of 16 or 8 bits with room for chance; without a sum all
that keep their length, and of lowiek one or two for a byte that was lost."""


@pytest.mark.parametrize(("name", "extra"), VARIANTS)
def test_false_frames_over_a_bad_cable(name: str, extra: dict[str, Any]) -> None:
    # enough packets that the checksum allows more than one false frame, as one may be chance
    found = judge(name, extra, 12_000 if name == "papillarray" else 4000, byte=2e-4)
    kind = "csv+check" if extra.get("check") else name
    assert found.damaged > 10
    assert found.false <= ALLOWED[kind] * found.damaged, found
    assert found.lost <= 3 * found.damaged, found
    assert found.said <= found.lost, found  # no number of a false frame makes up losses


def test_a_cable_without_faults_loses_nothing() -> None:
    for name, extra in VARIANTS:
        found = judge(name, extra, 1, byte=0.0, burst=0.0)
        assert (found.damaged, found.false, found.lost) == (0, 0, 0), name


def test_the_cable_does_what_it_says() -> None:
    packets, _ = stream("native", {}, 4000)
    arrived = damage(packets, np.random.default_rng(0), byte=1e-3, burst=0.0)
    touched = sum(a != b for a, b in zip(packets, arrived, strict=True))
    expected = sum(1 - (1 - 1e-3) ** len(packet) for packet in packets)
    assert abs(touched - expected) < 5 * expected**0.5
