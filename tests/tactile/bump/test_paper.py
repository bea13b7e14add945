"""The paper's Figs. 10 to 12 and the study of the sensor's place: every verdict and the numbers behind it."""

import importlib
import importlib.util
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from examples.paper.claims import Claim
from tests.kits.paths import ROOT

pytestmark = pytest.mark.slow

VERDICTS = {
    "fig10_deformation": [True, True],
    "fig11_depth": [True, True, False],  # the shear strain changes sign
    # cross-talk of second order; a contact that grows; 1.6 instead of 2; a shear strain near zero
    "fig12_linearity": [True, False, True, True, False, False, False],
}
NUMBERS = {
    ("fig11_depth", 0): (29.0, 17.7),
    ("fig11_depth", 2): (98, 286, 1, 6),
    ("fig12_linearity", 4): (100, 24, 20),
    ("fig12_linearity", 5): (1.53, 1.68),
    ("fig12_linearity", 6): (7, 9, 14, 159, 23, 10),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("drawn")


@cache
def claims(name: str, folder: Path) -> list[Claim]:
    """Compare, which takes seconds, and draw what is compared."""
    compare: Callable[[Path | None], list[Claim]] = importlib.import_module(f"examples.paper.{name}").compare
    return compare(folder)


@pytest.mark.parametrize("name", VERDICTS)
def test_verdicts(name: str, folder: Path) -> None:
    made = claims(name, folder)
    assert [claim.agrees for claim in made] == VERDICTS[name], made
    assert all(claim.figure == name[3:5] for claim in made)
    assert all(claim.why for claim in made if not claim.agrees)
    (drawn,) = folder.glob(f"fig{name[3:5]}*.png")
    with Image.open(drawn) as picture:
        grey = np.asarray(picture.convert("L"))
    assert grey.min() < 64
    assert grey.max() > 192


@pytest.mark.parametrize(("name", "index"), NUMBERS)
def test_numbers(name: str, index: int, folder: Path) -> None:
    said = [float(number) for number in re.findall(r"\d+(?:\.\d+)?", claims(name, folder)[index].ours)]
    wanted = NUMBERS[name, index]
    assert said[: len(wanted)] == pytest.approx(wanted, rel=0.03)


def study() -> ModuleType:
    path = ROOT / "examples" / "where_a_strain_sensor_should_sit.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_where_a_strain_sensor_should_sit() -> None:
    found = study().study()
    assert 60 < found["deepest without a change of sign [um]"] < 90
    assert found["spread of shear on the axis, 200 um"] == np.inf
    assert 1 < found["spread of shear on the axis, 20 um"] < 2.2
    assert 1 < found["spread of the pair's difference"] < 2.2
    assert found["pair's half difference [1/N]"] > found["largest shear on the axis at 200 um [1/N]"]
