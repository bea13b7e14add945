"""Faults of an emulated device: the reader counts each, and impossible settings are refused."""

from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.serial.faults import Faults
from tactile.wire.source import Chunk, WireSource
from tests.kits.serial import sent


@pytest.mark.parametrize("faults", [
    Faults(drop=0.1), Faults(repeat=0.1), Faults(flip=2e-4), Faults(split=True),
    Faults(drop=0.05, repeat=0.05, flip=1e-4, split=True),
])  # fmt: skip
def test_every_fault_is_counted(faults: Faults) -> None:
    description, stream = sent("native", 2.0)
    rng = np.random.default_rng(5)
    clean = list(WireSource(description, [Chunk(0, data) for _, data in stream]))
    pieces = [(piece, data) for _, data in stream for piece in faults.spoil(data, rng)]
    source = WireSource(description, [Chunk(0, piece) for piece, _ in pieces])
    frames = list(source)
    counts = source.counts
    truth = {(f.finger, f.sequence): f.values.tobytes() for f in clean}
    assert all(truth[f.finger, f.sequence] == f.values.tobytes() for f in frames)
    last = max(f.sequence for f in frames) - min(f.sequence for f in frames) + 1
    assert counts.good == len(frames)
    assert counts.good + counts.missing == pytest.approx(2 * last, abs=2)
    assert (counts.missing > 0) == (faults.drop > 0 or faults.flip > 0)
    assert (counts.repeated > 0) == (faults.repeat > 0)
    assert (counts.bad_checksum > 0) == (faults.flip > 0)


@pytest.mark.parametrize(("change", "message"), [
    ({"drop": 1.5}, "drop = 1.5, a number from 0 to 1"), ({"unplug": -1}, "unplug = -1.0"),
    ({"flip": float("nan")}, "flip"),
])  # fmt: skip
def test_impossible_faults_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Faults(**change)
