"""Recordings with bytes changed, lost or added: what can be read is read, the rest is an InputError."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.recording.reader import open_recording
from tests.kits.paths import SCENES
from tests.kits.serial import call

SCENE = SCENES / "needle.toml"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    file = tmp_path_factory.mktemp("damaged") / "whole.mcap"
    call("convert", SCENE, file)
    return file.read_bytes()


def read(file: Path) -> int:
    """Return how many frames there are."""
    return sum(1 for _ in open_recording(file).source())


@pytest.mark.parametrize("kind", ["changed", "lost", "added"])
def test_damage_is_no_crash(whole: bytes, tmp_path: Path, kind: str) -> None:
    file, random = tmp_path / "damaged.mcap", np.random.default_rng(1)
    file.write_bytes(whole)
    frames = read(file)
    assert frames > 20
    places = [*range(8, 2500, 23), *random.integers(2500, len(whole), 60).tolist()]
    for place in places:
        old = whole[place : place + 1]
        middle = {"changed": bytes([old[0] ^ 0x81]), "lost": b"", "added": old + b"\x9c"}[kind]
        file.write_bytes(whole[:place] + middle + whole[place + 1 :])
        with suppress(InputError):
            assert read(file) <= frames
