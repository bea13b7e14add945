"""Scaling study: the bytes of a frame, and one of its measurements."""

import numpy as np
import pytest

from tests.benchmarks.scaling import rates


def test_bytes_of_a_frame_are_those_that_the_native_format_sends() -> None:
    from tactile.wire.base import Options
    from tactile.wire.registry import find_format

    native = find_format("native")
    for side in (2, 8, 32):
        values = np.arange(3.0 * side * side).reshape(-1, 3) % 1000
        sent = native.encoder(Options(((side, side),), {"value": "int16"})).encode([values], 1, 0.0)
        assert abs(len(sent) - rates.wire_bytes(side)) <= 1 + len(sent) // 254


def test_the_stages_of_a_frame_are_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rates, "PATIENCE", 0.0)
    assert rates.measured(2)["frame"] > 0
