"""The scaling study runs: a handful of its cases."""

import numpy as np
import pytest

from tests.benchmarks.scaling import on_paper, places, rates


def test_bytes_of_a_frame_are_those_that_the_native_format_sends() -> None:
    from tactile.wire.base import Options
    from tactile.wire.registry import find_format

    native = find_format("native")
    for side in (2, 8, 32):
        values = np.arange(3.0 * side * side).reshape(-1, 3) % 1000
        sent = native.encoder(Options(((side, side),), {"value": "int16"})).encode([values], 1, 0.0)
        assert abs(len(sent) - rates.wire_bytes(side)) <= 1 + len(sent) // 254


def test_many_loads_are_all_located_and_the_rates_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rates, "PATIENCE", 0.0)
    row = places.measured(24, 1.5e-3, 1.5e-3, 1e-2, 6, 2)
    assert row["located lost"] == 0
    assert row["located mm"] < 0.1
    assert rates.measured(2)["frame"] > 0


def test_plans_on_paper_multiply_out() -> None:
    of = {row["what"]: row["value"] for row in [*on_paper.grid(1e-9), *on_paper.arrays(1e-4)]}
    assert of["core hours"] == pytest.approx(1e12 * 256 * (1 + 128 / 8192) ** 2 * 1e-9 / 3600)
    assert of["cores for the frames"] == pytest.approx(4096 * 1000 * 1e-4)
