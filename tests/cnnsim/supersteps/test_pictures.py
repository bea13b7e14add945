import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import cnnsim
from cnnsim.cli.group import main
from cnnsim.supersteps import pictures
from cnnsim.supersteps.pictures import open_large, write_large
from cnnsim.support import InputError

zarr = pytest.importorskip("zarr")
LEVELS = np.random.default_rng(2).integers(0, 256, (40, 30), dtype=np.uint8)
VALUES = 1 - LEVELS / 127.5


def test_a_picture_has_the_same_values_on_an_engine(tmp_path: Path) -> None:
    Image.fromarray(LEVELS).save(tmp_path / "p.png")
    np.save(tmp_path / "p.npy", LEVELS)
    np.save(tmp_path / "f.npy", VALUES)
    np.save(tmp_path / "black.npy", LEVELS > 100)
    zarr.create_array(tmp_path / "p.zarr", data=VALUES.astype("f4"), chunks=(16, 16))
    for name in ("p.png", "p.npy", "f.npy", "p.zarr"):
        plane = open_large(tmp_path / name)
        assert plane.shape == (40, 30)
        assert np.allclose(plane[10:20, 5:9], VALUES[10:20, 5:9], atol=1e-6)
    assert isinstance(open_large(tmp_path / "f.npy"), np.memmap)
    assert np.array_equal(open_large(tmp_path / "black.npy"), np.where(LEVELS > 100, 1, -1))
    assert np.array_equal(open_large(tmp_path / "p.npy", binary=True), np.where(VALUES > 0, 1, -1))
    assert np.allclose(open_large(tmp_path / "p.npy", levels=(255, 0)), -VALUES, atol=1e-6)


@pytest.mark.parametrize("name", ["y.npy", "y.pgm", "y.png", "y.tif"])
def test_outputs_are_written_in_parts_and_as_a_whole(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "ROWS", 7)
    for plane, wanted in ((1.5 * VALUES, np.clip(1.5 * VALUES, -1, 1)), (VALUES > 0, np.where(VALUES > 0, 1, -1))):
        write_large(plane, tmp_path / name)
        found = np.load(tmp_path / name) if name == "y.npy" else cnnsim.read_picture(tmp_path / name)
        assert np.allclose(found, wanted, atol=1 / 255)


def test_other_arrays_are_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "cube.npy", np.zeros((3, 4, 5)))
    with pytest.raises(InputError, match=r"float64 of shape \(3, 4, 5\); \(rows, cols\) of floats, levels or booleans"):
        open_large(tmp_path / "cube.npy")
    zarr.create_array(tmp_path / "p.zarr", data=LEVELS)
    with pytest.raises(InputError, match=r"uint8 of shape \(40, 30\); \(rows, cols\) of floats or booleans"):
        open_large(tmp_path / "p.zarr")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="cannot be read as a Zarr array"):
        open_large(tmp_path / "empty")


def test_the_command_gives_the_picture_of_a_run_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(LEVELS).save(tmp_path / "p.pgm")
    call = ["run", "averaging-threshold", "p.pgm", "--time", "2", "--json"]
    plain = CliRunner().invoke(main, [*call, "-o", "a.png"])
    parts = CliRunner().invoke(
        main, [*call, "-o", "b.png", "--engine", "processes", "--workers", "1", "--block", "16", "--store", "store"]
    )
    assert parts.exit_code == 0, parts.output
    assert json.loads(parts.stdout)["black"] == json.loads(plain.stdout)["black"]
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
