"""`tactile texture train`, `classify` and `report` on folders of slides, and wrong input."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tactile.cli.group import main
from tactile.materials.features import feature_set
from tactile.materials.novelty import numbered
from tactile.materials.slide_folder import read_slides
from tactile.materials.slide_labels import read_slide_labels
from tactile.materials.split import by_slide
from tactile.materials.windows import cut
from tactile.sources.convert import convert
from tests.kits.paths import DATA
from tests.kits.touch.slides import slides, write_slides

SHARED = DATA / "slides"
SCENE = """
title = "two materials"
rate_hz = 100
duration_s = 1.6
[cover]
youngs_modulus_mpa = 0.87
[[finger]]
name = "a"
rows = 2
cols = 2
pitch_mm = 1.5
depth_mm = 1.5
[[texture]]
finger = "a"
material = "MATERIAL"
speed_mm_s = 5
force_N = 0.3
start_s = 0.1
stop_s = 1.5
"""


def output(*words: object) -> str:
    done = CliRunner().invoke(main, ["texture", *map(str, words)])
    assert done.exit_code == 0, done.output
    return done.stdout


def refused(*words: object) -> str:
    done = CliRunner().invoke(main, ["texture", *map(str, words)])
    assert done.exit_code == 2, done.output
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    return line


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("made") / "slides"
    made.mkdir()
    write_slides(made / "s.npz", slides(4, ("screw", "rasp", "smooth wood"), 300), axes=(2, 0, 1))
    return made


def test_train_classify_and_report(folder: Path, tmp_path: Path) -> None:
    model = tmp_path / "m.npz"
    assert "3 materials of 12 slides: 2 features" in output(
        "train", folder, "-o", model, "--features", "figures", "--window", 64
    )
    classified = json.loads(output("classify", folder, "--model", model, "--json", "--confidence", 0))
    assert (classified["labelled"], classified["right"] >= 10) == (12, True)
    assert "slides with a known material are right" in output("classify", folder, "--model", model)
    assert "1e+03" not in output("classify", folder, "--model", model, "--speed", 5)
    assert "is there already" in refused("train", folder, "-o", model).replace("are", "is")
    assert "the model has windows of 64" in refused("classify", folder, "--model", model, "--window", 128)
    out = json.loads(output("report", folder, "-o", tmp_path / "out", "--window", 64, "--json"))
    assert out == json.loads((tmp_path / "out" / "report.json").read_text())
    full, figures = out["results"]
    assert (full["features"], figures["features"]) == ("full", "figures")
    assert full["by_slide"] > 0.9 > full["chance"]
    assert full["by_block"] is not None
    assert full["other_place"] is not None
    assert set(full["unknown_auroc_by_material"]) == {"screw", "rasp", "smooth wood"}
    assert sum(map(sum, full["confusion"])) == out["windows_side_by_side"]
    assert (
        (tmp_path / "out" / "figures.png").stat().st_size > 5000 < (tmp_path / "out" / "confusion.png").stat().st_size
    )


def test_recordings_are_labelled_by_folder_or_label_file(tmp_path: Path) -> None:
    for name in ("screw", "rasp"):
        (tmp_path / name).mkdir()
        scene = tmp_path / f"{name}.scene"
        scene.write_text(SCENE.replace("MATERIAL", name))
        scene.rename(tmp_path / name / "one.toml")
        convert(tmp_path / name / "one.toml", tmp_path / name / "two.npz")
    found = read_slides(tmp_path)
    assert [(one.material, one.name) for one in found] == [
        ("rasp", "one"), ("rasp", "two"), ("screw", "one"), ("screw", "two")
    ]  # fmt: skip
    assert all(0.1 <= one.t[0] < 0.15 and 1.4 < one.t[-1] <= 1.5 for one in found)
    assert np.median(found[2].force[:, 2]) == pytest.approx(0.3, rel=0.1)  # located force [N]
    mu = np.hypot(*found[2].force[:, :2].T) / found[2].force[:, 2]
    assert 0.3 < mu.mean() < 0.45  # the screw's friction is 0.35 to 0.45
    labels = tmp_path / "labels.csv"
    labels.write_text("recording,material,start_s,stop_s,speed_mm_s,block\ntwo,thread,0.5,1,5,3\n")
    (part,) = read_slides(tmp_path / "screw", read_slide_labels(labels))
    assert (part.material, part.speed, part.block, part.t[0], part.t[-1]) == ("thread", 0.005, 3, 0.5, 1.0)
    labels.write_text("recording,material\nthree,thread\n")
    with pytest.raises(Exception, match="no recording three, which the labels name"):
        read_slides(tmp_path, read_slide_labels(labels))


def test_wrong_input_is_refused_in_one_line(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "no scene or recording" in refused("report", tmp_path / "none")
    assert "no slides in it" in refused("report", tmp_path)
    (tmp_path / "labels.csv").write_text("recording\n")
    assert "recording and material wanted" in refused("report", folder, "--labels", tmp_path / "labels.csv")
    assert "a texture model wanted" in refused("classify", folder, "--model", folder / "s.npz")
    np.savez(tmp_path / "bad.npz", force=np.zeros((3, 3)), length=np.array([4]), t=np.zeros(3))
    assert "force of shape (3, 3); (4, 3) wanted" in refused("report", tmp_path / "bad.npz")
    assert ".npz wanted for a model" in refused("train", folder, "-o", tmp_path / "m.bin")
    output("train", folder, "-o", tmp_path / "figures.npz", "--features", "figures", "--window", 64)
    for name in [name for name in sys.modules if name.split(".")[0] == "sklearn"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "sklearn", None)
    json.loads(
        output("classify", folder, "--model", tmp_path / "figures.npz", "--json")
    )  # classification works without scikit-learn
    for words in (("report", folder), ("train", folder, "-o", tmp_path / "m.npz")):
        line = refused(*words)
        assert "learning textures needs scikit-learn, which is not installed: pip install" in line


@pytest.mark.skipif(not SHARED.exists(), reason="the shared recordings are not available")
def test_materials_of_real_slides() -> None:
    """Cross-validated accuracy on every fifth slide."""
    from tactile.materials.fit import fit

    every = read_slides(SHARED)[::5]
    for kind, least in (("figures", 0.45), ("full", 0.85)):
        features = feature_set(kind, 128, every)
        table = cut(every, features, 128)
        materials, numbers = numbered(table)
        right = []
        for train_on, test_on in by_slide(table, 128):
            space, known = fit(table.values[train_on], numbers[train_on], len(materials), features.kind)
            right += list(known.vote(space(table.values[test_on])).material == numbers[test_on])
        assert np.mean(right) >= least, kind
