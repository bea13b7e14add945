"""Forces on a cover of bumps: what the flat cover's inverse makes of them, and scenes that it cannot compute."""

import copy
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cnnsim.support import InputError
from tactile.calibration.radial import RadialCorrection
from tactile.cli.group import main
from tactile.core.frame import TaxelArray
from tactile.finger import Finger
from tactile.settings import Settings
from tactile.simulator.bump_cover import Bumps
from tactile.simulator.scene_file.file import scene_from
from tests.kits.paths import SCENES

FILE = SCENES / "bump.toml"
TEXT = FILE.read_text(encoding="utf-8")


def made(**changes: Any) -> Any:
    return scene_from(copy.deepcopy(tomllib.loads(TEXT)) | changes, "here")


def located(scene: Any, factor: float) -> float:
    finger = Finger(scene.arrays[0], scene.modulus, Settings(radial=RadialCorrection((0, 1), (0, 1), (factor, factor))))
    load = finger.locate(next(iter(scene)))
    assert load is not None
    return load.F


def test_forces_on_a_bump_come_back() -> None:
    """The flat cover's inverse, times what the table says, at another force than the table's; shear costs 2 %."""
    scene = made()
    factor = scene.bumps.over_flat(scene.arrays[0], "strain")
    assert factor == pytest.approx(3.5, abs=0.1)
    assert scene.bumps.over_flat(TaxelArray("deep", 2, 2, 1.5e-3, 1.5e-3), "strain") < factor
    done = CliRunner().invoke(main, ["run", str(FILE), "--json"])
    assert done.exit_code == 0
    assert f"forces are {factor:.3g} times a flat cover's" in done.stderr
    assert json.loads(done.stdout)["fingers"]["chip"]["frames"] == 600
    for force, shear, off in ((0.008, 0.0, 1e-6), (0.002, 0.0, 1e-6), (0.008, 0.003, 0.02)):
        scene = made(
            effect={}, duration_s=0.001, load=[{"finger": "chip", "path": [[0, -0.75, -0.75, shear, 0, force]]}]
        )
        found = located(scene, factor)
        assert found == pytest.approx(force, rel=off)
        assert located(scene, 1.0) == pytest.approx(found / factor)


def test_indentations_on_bumps_are_refused() -> None:
    ball = {"finger": "chip", "shape": "sphere", "radius_mm": 1, "path": [[0, 0, 0, 0, 0, 0.01], [1, 0, 0, 0, 0, 0.01]]}
    assert made(contact=[ball]).contacts
    with pytest.raises(InputError, match=r"here: contact 2: given = 'indentation' on bumps; 'force' wanted"):
        made(contact=[ball, ball | {"given": "indentation"}])


def test_fingers_of_several_depths_say_their_factors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = '[[finger]]\nname = "deep"\nrows = 2\ncols = 2\npitch_mm = 1.5\ndepth_mm = 1.0\n[[load]]'
    (tmp_path / "two.toml").write_text(TEXT.replace("[[load]]", other, 1), encoding="utf-8")
    monkeypatch.setattr(Bumps, "over_flat", lambda self, array, quantity: 2 + array.depth * 1e3)
    done = CliRunner().invoke(main, ["run", str(tmp_path / "two.toml")])
    assert done.exit_code == 0
    assert "so much they are right for a load on one bump: chip 2.2, deep 3" in done.stdout
