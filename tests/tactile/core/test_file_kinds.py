"""A file of the wrong kind is refused with its kind and the commands that read it."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cnnsim import InputError
from tactile.calibration.file import load_calibration
from tactile.cli.new_texts import ARRAY, DETECTOR, SCENE
from tactile.core.frame import TaxelArray
from tactile.events.detector_file import read_detector
from tactile.simulator.scene_file.file import read_scene
from tactile.wire.description_file import read_description

TEXTS = {"scene": SCENE, "array": ARRAY, "detector": DETECTOR}
READERS: dict[str, Callable[[Path], Any]] = {
    "scene": read_scene, "array description": read_description, "detector": read_detector,
    "calibration": load_calibration,
}  # fmt: skip


@pytest.mark.parametrize("wanted", READERS)
@pytest.mark.parametrize("given", ["scene", "array", "detector"])
def test_another_kind_of_file_is_refused_by_name(tmp_path: Path, given: str, wanted: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(TEXTS[given].replace("NAME", "mine"), encoding="utf-8")
    if wanted.startswith(given):
        READERS[wanted](path)
        return
    message = rf"mine.toml: an? {given}.*, as `tactile (run|live).*` takes it; a {wanted} wanted$"
    with pytest.raises(InputError, match=message) as raised:
        READERS[wanted](path)
    assert not re.search("unknown key", str(raised.value))


def test_the_array_name_hand_is_reserved() -> None:
    with pytest.raises(InputError, match="the name of events of several fingers"):
        TaxelArray("hand", 2, 2, 1e-3, 1e-3)
