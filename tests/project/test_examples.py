"""Every example runs, asserts what it shows or writes the picture it promises; importing one does nothing."""

import importlib.util
import inspect
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from cnnsim.library import folders
from tests.kits.paths import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("[!_]*.py"))
STUDIES = {
    "a_locking_element", "how_precise_must_a_chip_be", "parity_by_design", "program_gallery",
    "where_a_strain_sensor_should_sit",
}  # fmt: skip
"""Longer examples, and examples that only draw."""


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_example(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    module = _load(path)
    assert capsys.readouterr().out == ""
    assert not list(tmp_path.iterdir())
    if not inspect.signature(module.main).parameters:
        module.main()
        assert capsys.readouterr().out
        return
    module.main(tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        grey = np.asarray(picture.convert("L"))
    assert grey.min() < grey.max()


@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.stem not in STUDIES], ids=lambda path: path.stem)
def test_a_short_example_has_a_title_and_asserts_a_number_through_the_front_door(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) < 30
    assert lines[0].lower().startswith(f'"""{path.stem.replace("_", " ")}: ')
    assert any(line.strip().startswith("assert ") for line in lines)
    imported = {line.split()[1] for line in lines if line.startswith(("import ", "from "))}
    assert {name for name in imported if name.startswith(("cnnsim", "tactile"))} <= {"cnnsim", "tactile"}


def test_there_are_a_dozen_short_ones() -> None:
    short = [path.read_text(encoding="utf-8") for path in EXAMPLES if path.stem not in STUDIES]
    assert len(short) >= 12
    assert sum("import tactile" in text or "from tactile import" in text for text in short) >= 4


def test_the_gallery_shows_every_program() -> None:
    gallery = _load(ROOT / "examples" / "program_gallery.py")
    assert sorted({name for name, _, _ in gallery.scenes()}) == list(folders.programs())
