import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cnnsim
from cnnsim.cli.group import main
from cnnsim.supersteps.engine import Engine, side_of_blocks
from cnnsim.supersteps.pictures import TiledPicture, open_large
from cnnsim.supersteps.written import write_large
from cnnsim.support import InputError

LEVELS = np.random.default_rng(2).integers(0, 256, (40, 30), dtype=np.uint8)
VALUES = 1 - LEVELS / 127.5


def write_pgm(path: Path) -> None:
    path.write_bytes(b"P5\n30 40\n255\n" + LEVELS.tobytes())


def test_a_raw_picture_and_an_array_are_read_part_by_part_as_they_are_read_whole(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    write_pgm(tmp_path / "p.pgm")
    np.save(tmp_path / "p.npy", LEVELS)
    np.save(tmp_path / "black.npy", LEVELS > 100)
    zarr.create_array(tmp_path / "p.zarr", data=VALUES.astype("f4"), chunks=(16, 16))
    for name in ("p.pgm", "p.npy", "p.zarr"):
        plane = open_large(tmp_path / name)
        assert plane.shape == (40, 30)
        assert np.allclose(plane[10:20, 5:9], VALUES[10:20, 5:9], atol=1e-6)
    assert isinstance(open_large(tmp_path / "p.pgm")._levels, np.memmap)
    assert np.array_equal(open_large(tmp_path / "black.npy")[:, :], np.where(LEVELS > 100, 1, -1))
    assert np.array_equal(open_large(tmp_path / "p.npy", binary=True)[:, :], np.where(VALUES > 0, 1, -1))
    assert np.allclose(cnnsim.read_picture(tmp_path / "p.pgm"), open_large(tmp_path / "p.pgm")[:, :], atol=1e-6)


@pytest.mark.parametrize("name", ["y.npy", "y.pgm", "y.png"])
def test_outputs_are_written_strip_by_strip_as_they_are_whole(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cnnsim.supersteps.written.MOST", 30 * 7)
    write_large(TiledPicture(LEVELS, binary=False), tmp_path / name)
    found = np.load(tmp_path / name) if name == "y.npy" else cnnsim.read_picture(tmp_path / name)
    assert np.allclose(found, VALUES, atol=1e-6)


def test_what_is_no_picture_is_told(tmp_path: Path) -> None:
    np.save(tmp_path / "cube.npy", np.zeros((3, 4, 5)))
    with pytest.raises(InputError, match=r"float64 of shape \(3, 4, 5\); \(rows, cols\) of floats, levels or truth"):
        open_large(tmp_path / "cube.npy")
    with pytest.raises(InputError, match="cannot be read as a Zarr array"):
        open_large(tmp_path)


def test_the_command_runs_on_an_engine_as_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_pgm(tmp_path / "p.pgm")
    call = ["run", "averaging-threshold", "p.pgm", "--time", "2", "--json"]
    plain = CliRunner().invoke(main, [*call, "-o", "a.png"])
    parts = CliRunner().invoke(main, [*call, "-o", "b.png", "--engine", "processes", "--workers", "1", "--block", "16",
                                      "--store", "store"])  # fmt: skip
    assert parts.exit_code == 0, parts.output
    assert json.loads(parts.stdout)["black"] == json.loads(plain.stdout)["black"]
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_blocks_are_small_enough_for_all_workers_and_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "16G")
    plan = cnnsim.run_transient(cnnsim.Template(1.0), state=np.zeros((2, 2)), duration=0.1).plan
    large = plan.__class__(**{**vars(plan), "shape": (32768, 32768)})
    assert side_of_blocks(Engine(), large.shape, 2, sleeps=False) == 4096
    assert side_of_blocks(Engine(), large.shape, 2, sleeps=True) == 1024
    assert side_of_blocks(Engine(side=48), large.shape, 2, sleeps=True) == 48
    monkeypatch.setenv("CNNSIM_MEMORY", "512M")
    assert side_of_blocks(Engine(), large.shape, 2, sleeps=False) <= 1280
