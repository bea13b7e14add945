"""Pictures that are decoded strip by strip against the same pictures read whole by Pillow."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import cnnsim
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.pictures import open_large
from cnnsim.supersteps.strips import FileRows
from cnnsim.supersteps.written import write_large
from cnnsim.support import InputError

pytest.importorskip("OpenImageIO")
tifffile = pytest.importorskip("tifffile")

RANDOM = np.random.default_rng(5)
GREY = RANDOM.integers(0, 256, (70, 50), dtype=np.uint8)
RGBA = RANDOM.integers(0, 256, (70, 50, 4), dtype=np.uint8)
DEEP = GREY.astype(np.uint16) * 200


@pytest.fixture(autouse=True)
def _strips(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cnnsim.supersteps.pictures.WHOLE", 0)
    monkeypatch.setattr("cnnsim.supersteps.strips.MOST", 50 * 9)
    monkeypatch.setattr("cnnsim.supersteps.written.MOST", 50 * 11)


def _saved(name: str, path: Path) -> None:
    grey, rgba = Image.fromarray(GREY), Image.fromarray(RGBA)
    rgb = rgba.convert("RGB")
    pictures: dict[str, Any] = {
        "grey": grey, "bits": grey.convert("1"), "rgb": rgb, "rgba": rgba, "grey-alpha": rgba.convert("LA"),
        "deep": Image.fromarray(DEEP), "palette": rgb.quantize(16), "cmyk": rgb.convert("CMYK"),
    }  # fmt: skip
    more = {
        "clear": (grey, 5),
        "deep-clear": (pictures["deep"], int(DEEP[3, 4])),
        "palette-clear": (rgb.quantize(9), 3),
    }
    if name in pictures:
        pictures[name].save(path)
    else:
        image, clear = more[name]
        image.save(path, transparency=clear)


@pytest.mark.parametrize("name", ["grey.png", "bits.png", "rgb.png", "rgba.png", "grey-alpha.png", "deep.png",
                                  "palette.png", "clear.png", "deep-clear.png", "palette-clear.png", "grey.tif",
                                  "bits.tif", "rgb.tif", "rgba.tif", "deep.tif", "cmyk.tif"])  # fmt: skip
@pytest.mark.parametrize("binary", [False, True])
def test_strips_of_every_kind_of_picture_are_what_pillow_reads(name: str, binary: bool, tmp_path: Path) -> None:
    _saved(name.split(".")[0], tmp_path / name)
    plane = open_large(tmp_path / name, binary=binary)
    assert isinstance(plane._levels, FileRows)
    whole = cnnsim.read_picture(tmp_path / name, binary=binary, dtype=np.float32)
    assert np.array_equal(plane[:, :], whole)
    for part in np.s_[20:40, 10:20], np.s_[20:40, 30:50], np.s_[3:30, :], np.s_[..., 60:70, 0:7], np.s_[5:6]:
        assert np.array_equal(plane[part], whole[part])  # also backwards, and from what is kept


KINDS: dict[str, tuple[Any, dict[str, Any]]] = {
    "tiles": (GREY, {"tile": (16, 32)}),
    "deep-tiles": (DEEP, {"tile": (32, 16), "compression": None}),
    "one-strip": (DEEP, {"rowsperstrip": 70}),
    "floats": ((GREY / 255).astype("f4"), {"rowsperstrip": 4}),
    "values": ((1 - GREY / 127.5).astype("f4"), {"tile": (16, 16)}),
    "white-is-zero": (GREY, {"photometric": "miniswhite"}),
    "deep-white-is-zero": (DEEP, {"photometric": "miniswhite"}),
    "deep-colours": (RGBA[..., :3].astype("u2") * 257, {"photometric": "rgb"}),
    "planes": (np.moveaxis(RGBA[..., :3], 2, 0), {"photometric": "rgb", "planarconfig": "separate"}),
    "big": (GREY, {"bigtiff": True}),
}


@pytest.mark.parametrize("name", KINDS)
def test_strips_and_tiles_of_tiff_are_what_pillow_reads(name: str, tmp_path: Path) -> None:
    pixels, how = KINDS[name]
    path = tmp_path / "p.tif"
    tifffile.imwrite(path, pixels, **how)
    plane, whole = open_large(path), cnnsim.read_picture(path, dtype=np.float32)
    for part in np.s_[:, :], np.s_[20:40, 10:20], np.s_[20:40, 30:50], np.s_[3:30, :]:
        assert np.array_equal(plane[part], whole[part])


def test_a_range_is_told_or_found_as_elsewhere(tmp_path: Path) -> None:
    path = tmp_path / "p.tif"
    tifffile.imwrite(path, GREY.astype("f4"))
    for read in open_large, cnnsim.read_picture:
        with pytest.raises(InputError, match="holds numbers from 0 to 255 and does not say which are black and white"):
            read(path)
        found = read(path, levels=(255, 0))
        assert np.allclose(found[:, :], 2 * (GREY / 255.0) - 1, atol=1e-6)
    tifffile.imwrite(path, GREY.astype("i4"))
    for read in open_large, cnnsim.read_picture:
        with pytest.raises(InputError, match="whole numbers of 32 bits from 0 to 255"):
            read(path)


def test_what_cannot_be_read_in_strips_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "p.png"
    Image.fromarray(RANDOM.integers(0, 256, (70, 50), dtype=np.uint8)).save(path)
    path.write_bytes(path.read_bytes()[:2500])
    with pytest.raises(InputError, match="cannot be decoded from row"):
        open_large(path)[:, :]
    Image.fromarray(GREY).save(path)
    monkeypatch.setitem(__import__("sys").modules, "OpenImageIO", None)
    with pytest.raises(InputError, match="OpenImageIO reads and writes PNG and TIFF of this size, and is missing: pip"):
        open_large(path)


@pytest.mark.parametrize("name", ["y.png", "y.tif"])
def test_strips_are_written_as_a_picture_is_whole(name: str, tmp_path: Path) -> None:
    values = (1 - GREY / 127.5).astype("f4")
    write_large(values, tmp_path / name)
    assert np.array_equal(np.asarray(Image.open(tmp_path / name)), GREY)
    with pytest.raises(InputError, match="cannot write"):
        write_large(values, tmp_path / "none" / "y.xyz")


def test_a_picture_goes_by_strips_into_a_store_and_back(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    Image.fromarray(GREY).save(tmp_path / "p.png")
    engine = Engine(store=tmp_path / "s", workers=1, side=16)
    template = cnnsim.Template([[0, 0.2, 0], [0.2, 1.4, 0.2], [0, 0.2, 0]], 0.0, 0.1)
    wanted = cnnsim.run_transient(
        template, state=cnnsim.read_picture(tmp_path / "p.png"), duration=1.0, dtype="float32"
    )
    found = cnnsim.run_transient(template, state=open_large(tmp_path / "p.png"), duration=1.0, dtype="float32",
                                 engine=engine)  # fmt: skip
    assert np.array_equal(found.x[:, :], wanted.x)
    write_large(found.x, tmp_path / "y.png")
    cnnsim.write_picture(wanted.y, tmp_path / "z.png")
    assert np.array_equal(np.asarray(Image.open(tmp_path / "y.png")), np.asarray(Image.open(tmp_path / "z.png")))
